// A camera that GStreamer reads: whatever there is an element for, from V4L2 to RTSP.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_CAMERA_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_CAMERA_H_

#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/live/live_stream.h"

namespace corbslam::client_agent {

// How the pictures of a frame come.
enum class GstLayout {
  kOneCamera,     // A frame has one picture.
  kTwoPipelines,  // Each has its own pipeline; both run by one clock.
  kSideBySide,    // Left and right halves of one picture.
  kOneAbove,      // Upper (left camera) and lower half.
};

struct GstCameraOptions {
  // Elements from the source to raw video of any format, as gst-launch-1.0 takes them, without a
  // sink: "v4l2src device=/dev/video0".
  std::string first;
  std::string second;  // For kTwoPipelines only.
  GstLayout layout = GstLayout::kTwoPipelines;
  // Its pictures have 16 bits and are taken as they are; of grey ones 8 bits are made (GreyScaler).
  bool second_is_depth = false;
  // A pipeline that ends or fails, or one side of which ends while the other goes on, is started
  // again each second, as where a device was unplugged. Otherwise its end is the stream's. Nullopt:
  // one that fails and whose source is live, as devices and networks are and files are not.
  std::optional<bool> restarts;
};

// INVALID_ARGUMENT says why GStreamer doesn't understand a pipeline. Frames' times are the
// buffers' own, on the system's monotonic clock; where a buffer has none it is when it came, by the
// same clock, which is said once.
absl::StatusOr<std::unique_ptr<LiveCamera>> MakeGstCamera(const GstCameraOptions& options);

// Returns what MakeGstCamera would refuse. Touches no device.
absl::Status CheckGstCamera(const GstCameraOptions& options);

// Returns whether this machine's plugins have an element.
bool GstHasElement(const std::string& name);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_CAMERA_H_
