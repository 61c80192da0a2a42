// Opens live sources for tests.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_TESTING_OPEN_LIVE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_TESTING_OPEN_LIVE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "client_agent/live/gstreamer/gst_source.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::testing {

// A rig of pictures of 160 by 120 pixels.
inline constexpr char kSmallStereoRig[] =
    "rig: 1\nkind: stereo\nrectified: true\nbaseline_m: 0.1\ncameras:\n"
    "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [80, 60]}\n"
    "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [80, 60]}\n";

inline absl::StatusOr<std::unique_ptr<client_agent::FrameStream>> OpenLive(
    const std::string& source) {
  client_agent::RegisterGstSources();
  const auto spec = client_agent::ParseSourceSpec(source);
  if (!spec.ok()) return spec.status();
  const absl::Notification never;
  return spec->settings->OpenLive(never);
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_TESTING_OPEN_LIVE_H_
