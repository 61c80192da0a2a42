// Registers the kinds of sources that GStreamer plays: gst: and v4l2:.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SOURCE_H_

namespace corbslam::client_agent {

// Registers "gst:PIPELINE" and "v4l2:/dev/videoN[,/dev/videoM]" (docs/live.md) with this program.
void RegisterGstSources();

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_SOURCE_H_
