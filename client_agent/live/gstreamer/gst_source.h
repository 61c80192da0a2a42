// Registers the kinds of sources that GStreamer plays: gst:, v4l2: and aravis:.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SOURCE_H_

#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Registers "gst:PIPELINE", "v4l2:/dev/videoN[,/dev/videoM]" and "aravis:CAMERA[,CAMERA]"
// (docs/live.md) with this program.
void RegisterGstSources();

// Returns whether GStreamer has the element that a kind of source begins with on this machine.
bool IsGstSourceHere(absl::string_view kind);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SOURCE_H_
