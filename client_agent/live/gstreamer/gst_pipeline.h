// Makes a camera's GStreamer pipeline out of its text, and text for people out of its messages.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_PIPELINE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_PIPELINE_H_

#include <gst/gst.h>

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/live/gstreamer/gst_camera.h"
#include "client_agent/live/picture_pairing.h"

namespace corbslam::client_agent {

struct UnrefElement {
  void operator()(GstElement* element) const { gst_object_unref(element); }
};
using ElementPtr = std::unique_ptr<GstElement, UnrefElement>;

// Initialises GStreamer, once.
void InitialiseGst();

// Returns the pipeline, which no device was touched for. INVALID_ARGUMENT says what GStreamer
// doesn't understand, or which package has a part that is missing.
absl::StatusOr<ElementPtr> ParsePipeline(const GstCameraOptions& options);

// Returns the name of the element that takes a side's pictures, an appsink. Users' elements have
// other names.
const char* SinkName(LiveSide side);

// Returns "the left pipeline", "the depth pipeline" and so on; of one that holds both halves "the
// pipeline".
std::string NameOfSide(const GstCameraOptions& options, LiveSide side);

// Returns where to look when a device of these pipelines can't be opened, as another sentence;
// empty where they have none that is known.
std::string HintFor(absl::string_view pipelines);

// Returns what an error or a warning of the bus says, with its element and, of two pipelines, the
// one that it is in.
std::string TextOf(const GstCameraOptions& options, GstMessage* message);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_GST_PIPELINE_H_
