#include "client_agent/live/gstreamer/gst_camera.h"

#include <glog/logging.h>
#include <gst/app/gstappsink.h>
#include <gst/gst.h>

#include <atomic>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client_agent/live/grey_scaler.h"
#include "client_agent/live/gstreamer/gst_picture.h"
#include "client_agent/live/gstreamer/gst_pipeline.h"
#include "client_agent/live/gstreamer/gst_sides.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::Duration kBetweenStarts = absl::Seconds(1);
constexpr GstClockTime kBusWait_ns = 100 * GST_MSECOND;
constexpr GstClockTime kStartWait_ns = 10 * GST_SECOND;

constexpr char kWrong[] = "corbslam-wrong";  // A message of ours on the bus, with `why`.

class GstCamera : public LiveCamera {
 public:
  explicit GstCamera(const GstCameraOptions& options) : options_(options) {}
  ~GstCamera() override { Stop(); }

  absl::Status Start(PicturePairing& pairing) override {
    pairing_ = &pairing;
    ASSIGN_OR_RETURN(ElementPtr pipeline, Play());
    thread_ = StartThread(
        "camera", [this, running = std::move(pipeline)]() mutable { Keep(std::move(running)); });
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
    GstSide gave = {};
    std::atomic<bool> is_wrong = false;
  };

  // Makes the pipeline and waits until it plays.
  absl::StatusOr<ElementPtr> Play() {
    ASSIGN_OR_RETURN(ElementPtr pipeline, ParsePipeline(options_));
    Connect(pipeline.get(), first_);
    if (options_.layout == GstLayout::kTwoPipelines) Connect(pipeline.get(), second_);
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

  static void Connect(GstElement* pipeline, Sink& sink) {
    sink.gave.Reset();
    sink.is_wrong = false;
    GstElement* element = gst_bin_get_by_name(GST_BIN(pipeline), SinkName(sink.side));
    GstAppSinkCallbacks callbacks = {};
    callbacks.new_sample = &GstCamera::OnSample;
    callbacks.eos = [](GstAppSink*, gpointer data) { static_cast<Sink*>(data)->gave.ended = true; };
    gst_app_sink_set_callbacks(GST_APP_SINK(element), &callbacks, &sink, nullptr);
    gst_object_unref(element);
  }

  absl::Status FirstError(GstElement* pipeline) const {
    GstBus* bus = gst_element_get_bus(pipeline);
    GstMessage* message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
    gst_object_unref(bus);
    if (message == nullptr) {
      return absl::UnavailableError(absl::StrCat(
          "the pipeline does not start, and none of its elements says why: does it ask for a "
          "format, a size or a framerate that its source does not have? (gst-launch-1.0 -v tries "
          "it)",
          HintFor(options_.first)));
    }
    const absl::Status status = absl::UnavailableError(TextOf(options_, message));
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
      // The next start would give the same pictures.
      if (absl::IsInvalidArgument(ended)) return pairing_->End(ended);
      // A side that ended without an error has ended.
      const bool went_away = is_live_ && absl::IsUnavailable(ended);
      if (!options_.restarts.value_or(went_away)) return pairing_->End(ended);
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

  // Returns OK at the pipeline's end and when stopped, else the pipeline's error, or that of a side
  // that ended while the other goes on.
  absl::Status WaitForEnd(GstElement* pipeline) {
    GstBus* bus = gst_element_get_bus(pipeline);
    SideWatch watch(options_, first_.gave, second_.gave);
    std::optional<absl::Status> end;
    while (!end.has_value() && !stop_.HasBeenNotified()) {
      GstMessage* message = gst_bus_timed_pop_filtered(
          bus, kBusWait_ns,
          static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_EOS | GST_MESSAGE_WARNING |
                                      GST_MESSAGE_APPLICATION));
      if (message != nullptr) {
        end = Judge(message, watch);
        gst_message_unref(message);
      } else {
        end = watch.OneSideEnded(absl::Now());
      }
      if (!is_live_) watch.TellFast(absl::Now());
    }
    gst_object_unref(bus);
    return end.value_or(absl::OkStatus());
  }

  // Returns the end that a message of the bus means; nullopt where it means none.
  std::optional<absl::Status> Judge(GstMessage* message, const SideWatch& watch) const {
    switch (GST_MESSAGE_TYPE(message)) {
      case GST_MESSAGE_WARNING:
        LOG(WARNING) << TextOf(options_, message);
        return std::nullopt;
      case GST_MESSAGE_ERROR:
        return absl::UnavailableError(TextOf(options_, message));
      case GST_MESSAGE_EOS:
        watch.TellCounts();
        return absl::OkStatus();
      default:
        const GstStructure* const said = gst_message_get_structure(message);
        if (said == nullptr || gst_structure_has_name(said, kWrong) == FALSE) return std::nullopt;
        return absl::InvalidArgumentError(gst_structure_get_string(said, "why"));
    }
  }

  static GstFlowReturn OnSample(GstAppSink* sink, gpointer data) {
    auto& self = *static_cast<Sink*>(data);
    GstSample* sample = gst_app_sink_pull_sample(sink);
    if (sample == nullptr) return GST_FLOW_EOS;
    self.camera->Take(GST_ELEMENT(sink), sample, self);
    gst_sample_unref(sample);
    return GST_FLOW_OK;
  }

  void Take(GstElement* element, GstSample* sample, Sink& sink) {
    std::optional<cv::Mat> image = CopyPicture(sample);
    const bool is_depth = options_.second_is_depth && sink.side == LiveSide::kSecond;
    if (!image.has_value() || (is_depth && image->type() != CV_16UC1)) {
      return Refuse(element, sample, sink);
    }
    const int64_t time_ns = TimeOf(element, sample);
    sink.gave.Add(time_ns);
    if (!is_depth) image = grey_scaler_.ToEightBits(*image);
    if (options_.layout == GstLayout::kTwoPipelines || options_.layout == GstLayout::kOneCamera) {
      return pairing_->Push(sink.side, {time_ns, *std::move(image)});
    }
    auto [first, second] = SplitPicture(*image, options_.layout == GstLayout::kSideBySide);
    pairing_->Push(LiveSide::kFirst, {time_ns, std::move(first)});
    pairing_->Push(LiveSide::kSecond, {time_ns, std::move(second)});
  }

  // Ends the stream with the format that came, once.
  void Refuse(GstElement* element, GstSample* sample, Sink& sink) const {
    if (sink.is_wrong.exchange(true)) return;
    const GstCaps* const caps = gst_sample_get_caps(sample);
    gchar* const format = caps != nullptr ? gst_caps_to_string(caps) : nullptr;
    const std::string why = absl::StrCat(
        NameOfSide(options_, sink.side), " gives ", format != nullptr ? format : "no format", ", ",
        options_.second_is_depth && sink.side == LiveSide::kSecond
            ? "and depth is GRAY16_LE or GRAY16_BE, in the rig's units (depth.units_per_m): "
              "nothing "
              "is converted into depth. Is it the colour camera's? gst:PICTURE || DEPTH"
            : "which can't be made grey");
    g_free(format);
    gst_element_post_message(
        element, gst_message_new_application(
                     GST_OBJECT(element),
                     gst_structure_new(kWrong, "why", G_TYPE_STRING, why.c_str(), nullptr)));
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
  GreyScaler grey_scaler_;
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

absl::Status CheckGstCamera(const GstCameraOptions& options) {
  return ParsePipeline(options).status();
}

absl::StatusOr<std::unique_ptr<LiveCamera>> MakeGstCamera(const GstCameraOptions& options) {
  RETURN_IF_ERROR(ParsePipeline(options).status());
  return std::make_unique<GstCamera>(options);
}

}  // namespace corbslam::client_agent
