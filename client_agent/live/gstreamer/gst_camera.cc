#include "client_agent/live/gstreamer/gst_camera.h"

#include <glog/logging.h>
#include <gst/app/gstappsink.h>
#include <gst/gst.h>
#include <gst/video/video.h>

#include <atomic>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "client_agent/live/gstreamer/gst_picture.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::Duration kBetweenStarts = absl::Seconds(1);
constexpr GstClockTime kBusWait_ns = 100 * GST_MSECOND;
constexpr GstClockTime kStartWait_ns = 10 * GST_SECOND;

struct Unref {
  void operator()(GstElement* element) const { gst_object_unref(element); }
};
using ElementPtr = std::unique_ptr<GstElement, Unref>;

std::string SinkOf(const std::string& pipeline, const char* name, bool depth) {
  return absl::StrCat(
      pipeline, " ! videoconvert ! video/x-raw,format=", depth ? "GRAY16_LE" : "GRAY8",
      " ! appsink name=", name, " max-buffers=2 drop=true sync=false emit-signals=false ");
}

std::string DescribePipeline(const GstCameraOptions& options) {
  std::string text = SinkOf(options.first, "first", false);
  if (options.layout == GstLayout::kTwoPipelines) {
    text += SinkOf(options.second, "second", options.second_is_depth);
  }
  return text;
}

void InitialiseGst() {
  static std::once_flag once;
  std::call_once(once, [] { gst_init(nullptr, nullptr); });
}

// Where Debian has the elements that cameras want.
constexpr std::pair<absl::string_view, absl::string_view> kPackages[] = {
    {"aravissrc", "libaravis-0.8-0"},         {"bayer2rgb", "gstreamer1.0-plugins-bad"},
    {"v4l2src", "gstreamer1.0-plugins-good"}, {"jpegdec", "gstreamer1.0-plugins-good"},
    {"rtspsrc", "gstreamer1.0-plugins-good"}, {"avdec_h264", "gstreamer1.0-libav"}};

absl::Status BadPipeline(absl::string_view why) {
  for (const auto& [element, package] : kPackages) {
    if (!absl::StrContains(why, absl::StrCat("\"", element, "\""))) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("GStreamer lacks a part: ", why, "; Debian's package ", package, " has it"));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "GStreamer does not understand the pipeline: ", why, " (gst-launch-1.0 -v tries it)"));
}

absl::StatusOr<ElementPtr> Parse(const GstCameraOptions& options) {
  InitialiseGst();
  GError* error = nullptr;
  ElementPtr pipeline(gst_parse_launch_full(DescribePipeline(options).c_str(), nullptr,
                                            GST_PARSE_FLAG_FATAL_ERRORS, &error));
  if (error == nullptr && pipeline != nullptr) return pipeline;
  const std::string why = error != nullptr ? error->message : "no reason is given";
  if (error != nullptr) g_error_free(error);
  return BadPipeline(why);
}

// Returns what an error message of the bus says.
absl::Status ErrorOf(GstMessage* message) {
  GError* error = nullptr;
  gchar* detail = nullptr;
  gst_message_parse_error(message, &error, &detail);
  const absl::Status status = absl::UnavailableError(
      absl::StrCat(GST_OBJECT_NAME(message->src), ": ", error->message,
                   detail != nullptr ? absl::StrCat(" (", detail, ")") : ""));
  g_error_free(error);
  g_free(detail);
  return status;
}

class GstCamera : public LiveCamera {
 public:
  explicit GstCamera(const GstCameraOptions& options) : options_(options) {}
  ~GstCamera() override { Stop(); }

  absl::Status Start(PicturePairing& pairing) override {
    pairing_ = &pairing;
    ASSIGN_OR_RETURN(ElementPtr pipeline, Play());
    thread_ =
        std::thread([this, running = std::move(pipeline)]() mutable { Keep(std::move(running)); });
    return absl::OkStatus();
  }
  void Stop() override {
    if (!stop_.HasBeenNotified()) stop_.Notify();
    if (thread_.joinable()) thread_.join();
  }

 private:
  struct Sink {
    GstCamera* camera;
    LiveSide side;
  };

  // Makes the pipeline and waits until it plays.
  absl::StatusOr<ElementPtr> Play() {
    ASSIGN_OR_RETURN(ElementPtr pipeline, Parse(options_));
    Connect(pipeline.get(), "first", first_);
    if (options_.layout == GstLayout::kTwoPipelines) Connect(pipeline.get(), "second", second_);
    // The system's monotonic clock stamps everything, so that frames after a new start follow.
    GstClock* clock = gst_system_clock_obtain();
    gst_pipeline_use_clock(GST_PIPELINE(pipeline.get()), clock);
    gst_object_unref(clock);
    const GstStateChangeReturn paused = Reach(pipeline.get(), GST_STATE_PAUSED);
    // A live source gives nothing while it is paused.
    is_live_ = paused == GST_STATE_CHANGE_NO_PREROLL;
    if (paused != GST_STATE_CHANGE_FAILURE &&
        Reach(pipeline.get(), GST_STATE_PLAYING) != GST_STATE_CHANGE_FAILURE) {
      return pipeline;
    }
    const absl::Status why = FirstError(pipeline.get());
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
    return why;
  }

  static GstStateChangeReturn Reach(GstElement* pipeline, GstState state) {
    gst_element_set_state(pipeline, state);
    return gst_element_get_state(pipeline, nullptr, nullptr, kStartWait_ns);
  }

  void Connect(GstElement* pipeline, const char* name, Sink& sink) {
    GstElement* element = gst_bin_get_by_name(GST_BIN(pipeline), name);
    GstAppSinkCallbacks callbacks = {};
    callbacks.new_sample = &GstCamera::OnSample;
    gst_app_sink_set_callbacks(GST_APP_SINK(element), &callbacks, &sink, nullptr);
    gst_object_unref(element);
  }

  static absl::Status FirstError(GstElement* pipeline) {
    GstBus* bus = gst_element_get_bus(pipeline);
    GstMessage* message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
    gst_object_unref(bus);
    if (message == nullptr) return absl::UnavailableError("the pipeline does not start");
    const absl::Status status = ErrorOf(message);
    gst_message_unref(message);
    return status;
  }

  // Runs until it is stopped or the pipeline ends for good.
  void Keep(ElementPtr pipeline) {
    while (true) {
      const absl::Status ended = WaitForEnd(pipeline.get());
      gst_element_set_state(pipeline.get(), GST_STATE_NULL);
      pipeline.reset();
      if (stop_.HasBeenNotified()) return;
      if (!options_.restarts.value_or(is_live_ && !ended.ok())) return pairing_->End(ended);
      LOG(WARNING) << "the camera went away: "
                   << (ended.ok() ? "its pipeline ended" : ended.message())
                   << "; waiting for it to come back";
      pipeline = StartAgain();
      if (pipeline == nullptr) return;
      LOG(WARNING) << "the camera is back";
    }
  }

  // Returns null when stopped.
  ElementPtr StartAgain() {
    while (!stop_.WaitForNotificationWithTimeout(kBetweenStarts)) {
      absl::StatusOr<ElementPtr> pipeline = Play();
      if (pipeline.ok()) return *std::move(pipeline);
    }
    return nullptr;
  }

  // Returns OK at the pipeline's end and when stopped, else the pipeline's error.
  absl::Status WaitForEnd(GstElement* pipeline) {
    GstBus* bus = gst_element_get_bus(pipeline);
    absl::Status status;
    while (!stop_.HasBeenNotified()) {
      GstMessage* message = gst_bus_timed_pop_filtered(
          bus, kBusWait_ns, static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_EOS));
      if (message == nullptr) continue;
      if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) status = ErrorOf(message);
      gst_message_unref(message);
      break;
    }
    gst_object_unref(bus);
    return status;
  }

  static GstFlowReturn OnSample(GstAppSink* sink, gpointer data) {
    auto& self = *static_cast<Sink*>(data);
    GstSample* sample = gst_app_sink_pull_sample(sink);
    if (sample == nullptr) return GST_FLOW_EOS;
    self.camera->Take(GST_ELEMENT(sink), sample, self.side);
    gst_sample_unref(sample);
    return GST_FLOW_OK;
  }

  void Take(GstElement* sink, GstSample* sample, LiveSide side) {
    std::optional<cv::Mat> image = CopyPicture(sample);
    if (!image.has_value()) return;
    const int64_t time_ns = TimeOf(sink, sample);
    if (options_.layout == GstLayout::kTwoPipelines) {
      return pairing_->Push(side, {time_ns, *std::move(image)});
    }
    auto [first, second] = SplitPicture(*image, options_.layout == GstLayout::kSideBySide);
    pairing_->Push(LiveSide::kFirst, {time_ns, std::move(first)});
    pairing_->Push(LiveSide::kSecond, {time_ns, std::move(second)});
  }

  int64_t TimeOf(GstElement* sink, GstSample* sample) {
    const GstBuffer* buffer = gst_sample_get_buffer(sample);
    const GstClockTime stamp = GST_BUFFER_PTS(buffer);
    if (GST_CLOCK_TIME_IS_VALID(stamp)) {
      const GstSegment* segment = gst_sample_get_segment(sample);
      const GstClockTime running = gst_segment_to_running_time(segment, GST_FORMAT_TIME, stamp);
      if (GST_CLOCK_TIME_IS_VALID(running)) {
        return static_cast<int64_t>(gst_element_get_base_time(sink) + running);
      }
    }
    if (!told_.exchange(true)) {
      LOG(WARNING) << "the camera gives no times: frames have those at which they came, which are "
                      "later than the exposure by what the way here takes";
    }
    // The clock of the buffers that have times: one without must not lie years beside the others.
    GstClock* clock = gst_system_clock_obtain();
    const GstClockTime now = gst_clock_get_time(clock);
    gst_object_unref(clock);
    return static_cast<int64_t>(now);
  }

  const GstCameraOptions options_;
  PicturePairing* pairing_ = nullptr;
  Sink first_ = {this, LiveSide::kFirst};
  Sink second_ = {this, LiveSide::kSecond};
  bool is_live_ = false;  // What Play found last.
  std::atomic<bool> told_ = false;
  absl::Notification stop_;
  std::thread thread_;
};

}  // namespace

bool GstHasElement(const std::string& name) {
  InitialiseGst();
  GstElementFactory* const factory = gst_element_factory_find(name.c_str());
  if (factory == nullptr) return false;
  gst_object_unref(factory);
  return true;
}

absl::StatusOr<std::unique_ptr<LiveCamera>> MakeGstCamera(const GstCameraOptions& options) {
  RETURN_IF_ERROR(Parse(options).status());
  return std::make_unique<GstCamera>(options);
}

}  // namespace corbslam::client_agent
