// Opens a source that is a live camera.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LIVE_OPENING_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LIVE_OPENING_H_

#include <memory>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_description.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {

bool IsLive(const SourceSpec& spec);

struct LiveSource {
  std::unique_ptr<FrameStream> stream;
  SourceDescription description;
};

// Opens and starts the camera of a live spec. INVALID_ARGUMENT names options that are of recordings
// alone; other errors are the camera's. A source that waits for its camera waits until `stop`.
absl::StatusOr<LiveSource> OpenLiveSource(const SourceSpec& spec, const absl::Notification& stop);

// Says the same as far as that can be known without starting the camera or waiting for anybody.
absl::Status CheckLiveSource(const SourceSpec& spec);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LIVE_OPENING_H_
