#include "client_agent/live/gstreamer/gst_pipeline.h"

#include <mutex>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {
namespace {

// Pipelines are shorter.
constexpr int kMostElements = 100;

std::string AppSink(LiveSide side) {
  return absl::StrCat("appsink name=", SinkName(side),
                      " max-buffers=2 drop=true sync=false emit-signals=false ");
}

const char* ConverterName(LiveSide side) {
  return side == LiveSide::kFirst ? "corbslam_grey_first" : "corbslam_grey_second";
}

const char* FilterName(LiveSide side) {
  return side == LiveSide::kFirst ? "corbslam_filter_first" : "corbslam_filter_second";
}

// Colour becomes grey, and a source that can choose chooses 8 bits. KeepSixteenBits is about one
// that can't.
std::string GreySink(const std::string& pipeline, LiveSide side) {
  return absl::StrCat(pipeline, " ! videoconvert name=", ConverterName(side),
                      " ! capsfilter name=", FilterName(side),
                      " caps=\"video/x-raw,format=GRAY8\" ! ", AppSink(side));
}

// A camera that gives grey of 16 bits may use fewer: GreyScaler makes 8 of them, and not the
// converter, which would keep the upper ones.
GstPadProbeReturn OnConvertersCaps(GstPad*, GstPadProbeInfo* info, gpointer filter) {
  GstEvent* const event = GST_PAD_PROBE_INFO_EVENT(info);
  if (GST_EVENT_TYPE(event) != GST_EVENT_CAPS) return GST_PAD_PROBE_OK;
  GstCaps* came = nullptr;
  gst_event_parse_caps(event, &came);
  const char* const format = gst_structure_get_string(gst_caps_get_structure(came, 0), "format");
  const bool is_sixteen = format != nullptr && absl::StartsWith(format, "GRAY16");
  GstCaps* const wanted = gst_caps_new_simple("video/x-raw", "format", G_TYPE_STRING,
                                              is_sixteen ? "GRAY16_LE" : "GRAY8", nullptr);
  g_object_set(filter, "caps", wanted, nullptr);
  gst_caps_unref(wanted);
  return GST_PAD_PROBE_OK;
}

void KeepSixteenBits(GstElement* pipeline, LiveSide side) {
  GstElement* const converter = gst_bin_get_by_name(GST_BIN(pipeline), ConverterName(side));
  if (converter == nullptr) return;
  GstPad* const pad = gst_element_get_static_pad(converter, "sink");
  gst_object_unref(converter);
  gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, &OnConvertersCaps,
                    gst_bin_get_by_name(GST_BIN(pipeline), FilterName(side)), &gst_object_unref);
  gst_object_unref(pad);
}

// Nothing is converted: what isn't depth must not become depth. A source that can give it does; of
// another one the format is refused by its name when it comes.
std::string DepthSink(const std::string& pipeline, LiveSide side) {
  return absl::StrCat(pipeline,
                      " ! capsfilter caps=\"video/x-raw,format=(string){GRAY16_LE,GRAY16_BE};"
                      "video/x-raw\" ! ",
                      AppSink(side));
}

std::string DescribePipeline(const GstCameraOptions& options) {
  std::string text = GreySink(options.first, LiveSide::kFirst);
  if (options.layout != GstLayout::kTwoPipelines) return text;
  return text + (options.second_is_depth ? DepthSink(options.second, LiveSide::kSecond)
                                         : GreySink(options.second, LiveSide::kSecond));
}

// Debian has the elements that cameras want in these packages.
constexpr std::pair<absl::string_view, absl::string_view> kPackages[] = {
    {"aravissrc", "libaravis-0.8-0"},         {"bayer2rgb", "gstreamer1.0-plugins-bad"},
    {"v4l2src", "gstreamer1.0-plugins-good"}, {"jpegdec", "gstreamer1.0-plugins-good"},
    {"rtspsrc", "gstreamer1.0-plugins-good"}, {"avdec_h264", "gstreamer1.0-libav"}};

// Returns what gst-launch-1.0 calls such elements.
std::string KindOf(GstElement* element) {
  GstElementFactory* const factory = gst_element_get_factory(element);
  return factory != nullptr ? GST_OBJECT_NAME(factory) : GST_OBJECT_NAME(element);
}

// Returns the name of a sink that the user's own pipeline has; empty if it has none, or can't be
// understood by itself.
std::string SinkOf(const std::string& text) {
  if (text.empty()) return "";
  GError* error = nullptr;
  const ElementPtr parsed(
      gst_parse_launch_full(text.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error));
  if (error != nullptr) g_error_free(error);
  if (error != nullptr || parsed == nullptr) return "";
  if (!GST_IS_BIN(parsed.get())) {
    const bool is_sink = GST_OBJECT_FLAG_IS_SET(parsed.get(), GST_ELEMENT_FLAG_SINK);
    return is_sink ? KindOf(parsed.get()) : "";
  }
  GstIterator* const sinks = gst_bin_iterate_sinks(GST_BIN(parsed.get()));
  GValue item = G_VALUE_INIT;
  std::string name;
  while (name.empty() && gst_iterator_next(sinks, &item) == GST_ITERATOR_OK) {
    GstElement* const sink = GST_ELEMENT(g_value_get_object(&item));
    if (GST_OBJECT_FLAG_IS_SET(sink, GST_ELEMENT_FLAG_SINK)) name = KindOf(sink);
    g_value_reset(&item);
  }
  if (G_IS_VALUE(&item)) g_value_unset(&item);
  gst_iterator_free(sinks);
  return name;
}

// Where to look when a device can't be opened.
constexpr std::pair<absl::string_view, absl::string_view> kHints[] = {
    {"aravissrc",
     "Is a camera there? arv-tool-0.8 lists those that answer: one at the network needs an address "
     "of "
     "this machine's network, one at USB the rights of udev's rules, and neither another program "
     "that "
     "has it"},
    {"v4l2src",
     "v4l2-ctl --list-devices lists the cameras; who runs the robot must be of the group video, "
     "and no "
     "other program may have it"}};

absl::Status BadPipeline(absl::string_view why) {
  for (const auto& [element, package] : kPackages) {
    if (!absl::StrContains(why, absl::StrCat("\"", element, "\""))) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("GStreamer lacks a part: ", why, "; Debian's package ", package, " has it"));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "GStreamer does not understand the pipeline: ", why, " (gst-launch-1.0 -v tries it)"));
}

// Returns the element that follows another one in a pipeline; null after the last.
GstElement* NextElement(GstElement* element) {
  GstIterator* const pads = gst_element_iterate_src_pads(element);
  GValue item = G_VALUE_INIT;
  GstElement* next = nullptr;
  while (next == nullptr && gst_iterator_next(pads, &item) == GST_ITERATOR_OK) {
    GstPad* const peer = gst_pad_get_peer(GST_PAD(g_value_get_object(&item)));
    if (peer != nullptr) {
      next = gst_pad_get_parent_element(peer);
      gst_object_unref(peer);
    }
    g_value_reset(&item);
  }
  if (G_IS_VALUE(&item)) g_value_unset(&item);
  gst_iterator_free(pads);
  return next;
}

// Returns the element of the whole pipeline that holds `object`; null where that is the pipeline.
GstElement* TopElement(GstObject* object) {
  auto* at = GST_OBJECT(gst_object_ref(object));
  while (true) {
    GstObject* const parent = gst_object_get_parent(at);
    GstObject* const above = parent != nullptr ? gst_object_get_parent(parent) : nullptr;
    const bool is_top = parent != nullptr && above == nullptr;
    if (above != nullptr) gst_object_unref(above);
    if (is_top && GST_IS_ELEMENT(at)) {
      gst_object_unref(parent);
      return GST_ELEMENT(at);
    }
    gst_object_unref(at);
    if (parent == nullptr) return nullptr;
    at = parent;
  }
}

std::optional<LiveSide> SideOf(GstObject* object) {
  GstElement* element = TopElement(object);
  for (int i = 0; element != nullptr && i < kMostElements; ++i) {
    for (const LiveSide side : {LiveSide::kFirst, LiveSide::kSecond}) {
      if (absl::string_view(GST_OBJECT_NAME(element)) != SinkName(side)) continue;
      gst_object_unref(element);
      return side;
    }
    GstElement* const next = NextElement(element);
    gst_object_unref(element);
    element = next;
  }
  if (element != nullptr) gst_object_unref(element);
  return std::nullopt;
}

}  // namespace

void InitialiseGst() {
  static std::once_flag once;
  std::call_once(once, [] { gst_init(nullptr, nullptr); });
}

const char* SinkName(LiveSide side) {
  return side == LiveSide::kFirst ? "corbslam_first" : "corbslam_second";
}

absl::StatusOr<ElementPtr> ParsePipeline(const GstCameraOptions& options) {
  InitialiseGst();
  GError* error = nullptr;
  ElementPtr pipeline(gst_parse_launch_full(DescribePipeline(options).c_str(), nullptr,
                                            GST_PARSE_FLAG_FATAL_ERRORS, &error));
  if (error == nullptr && pipeline != nullptr) {
    KeepSixteenBits(pipeline.get(), LiveSide::kFirst);
    KeepSixteenBits(pipeline.get(), LiveSide::kSecond);
    return pipeline;
  }
  const std::string why = error != nullptr ? error->message : "no reason is given";
  if (error != nullptr) g_error_free(error);
  for (const std::string& text : {options.first, options.second}) {
    const std::string sink = SinkOf(text);
    if (sink.empty()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("the pipeline ends in a sink, ", sink,
                     ": leave it out. The robot takes the pictures from the element before it"));
  }
  return BadPipeline(why);
}

std::string NameOfSide(const GstCameraOptions& options, LiveSide side) {
  if (options.layout != GstLayout::kTwoPipelines) return "the pipeline";
  if (side == LiveSide::kFirst) {
    return options.second_is_depth ? "the picture's pipeline" : "the left pipeline";
  }
  return options.second_is_depth ? "the depth pipeline" : "the right pipeline";
}

std::string HintFor(absl::string_view pipelines) {
  for (const auto& [element, hint] : kHints) {
    if (absl::StrContains(pipelines, element)) return absl::StrCat(". ", hint);
  }
  return "";
}

std::string TextOf(const GstCameraOptions& options, GstMessage* message) {
  GError* error = nullptr;
  gchar* detail = nullptr;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING) {
    gst_message_parse_warning(message, &error, &detail);
  } else {
    gst_message_parse_error(message, &error, &detail);
  }
  const std::optional<LiveSide> side =
      options.layout == GstLayout::kTwoPipelines ? SideOf(message->src) : std::nullopt;
  std::string text =
      absl::StrCat(side.has_value() ? absl::StrCat(NameOfSide(options, *side), ": ") : "",
                   GST_OBJECT_NAME(message->src), ": ", error->message,
                   detail != nullptr ? absl::StrCat(" (", detail, ")") : "");
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR && GST_IS_ELEMENT(message->src)) {
    absl::StrAppend(&text, HintFor(KindOf(GST_ELEMENT(message->src))));
  }
  g_error_free(error);
  g_free(detail);
  return text;
}

}  // namespace corbslam::client_agent
