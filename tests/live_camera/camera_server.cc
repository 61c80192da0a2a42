#include "tests/live_camera/camera_server.h"

#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace corbslam::tests {
namespace {

constexpr absl::Duration kPoll = absl::Milliseconds(5);

absl::Status Missing(const GError* error) {
  return absl::UnavailableError(
      absl::StrCat("GStreamer can't serve pictures (gstreamer1.0-plugins-base and -good): ",
                   error != nullptr ? error->message : "no reason is given"));
}

class MatroskaServer : public CameraServer {
 public:
  explicit MatroskaServer(GstElement* pipeline)
      : pipeline_(pipeline),
        feed_(gst_bin_get_by_name(GST_BIN(pipeline), "feed")),
        out_(gst_bin_get_by_name(GST_BIN(pipeline), "out")) {}
  ~MatroskaServer() override {
    gst_element_set_state(pipeline_, GST_STATE_NULL);
    gst_object_unref(feed_);
    gst_object_unref(out_);
    gst_object_unref(pipeline_);
  }

  bool Play() {
    gst_element_set_state(pipeline_, GST_STATE_PLAYING);
    // The port is known once the socket is there; the first picture makes the rest play.
    const absl::Time deadline = absl::Now() + absl::Seconds(5);
    while (port() == 0 && absl::Now() < deadline) absl::SleepFor(kPoll);
    return port() != 0;
  }

  int port() const override { return Number("current-port"); }
  absl::Status WaitForRobot(absl::Duration timeout) override {
    const absl::Time deadline = absl::Now() + timeout;
    while (Number("num-handles") == 0) {
      if (absl::Now() > deadline) return absl::DeadlineExceededError("no robot connected");
      absl::SleepFor(kPoll);
    }
    return absl::OkStatus();
  }
  absl::Status Give(const cv::Mat& picture, absl::Duration stamp) override {
    const cv::Mat whole = picture.isContinuous() ? picture : picture.clone();
    GstBuffer* buffer = gst_buffer_new_memdup(whole.data, whole.total());
    GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(absl::ToInt64Nanoseconds(stamp));
    const GstFlowReturn flow = gst_app_src_push_buffer(GST_APP_SRC(feed_), buffer);
    if (flow == GST_FLOW_OK) return absl::OkStatus();
    return absl::UnavailableError(absl::StrCat("a picture was refused: ", gst_flow_get_name(flow)));
  }
  void Finish() override {
    gst_app_src_end_of_stream(GST_APP_SRC(feed_));
    GstBus* bus = gst_element_get_bus(pipeline_);
    GstMessage* message = gst_bus_timed_pop_filtered(
        bus, 5 * GST_SECOND, static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
    if (message != nullptr) gst_message_unref(message);
    gst_object_unref(bus);
  }

 private:
  int Number(const char* property) const {
    GValue value = G_VALUE_INIT;
    g_object_get_property(G_OBJECT(out_), property, &value);
    GValue number = G_VALUE_INIT;
    g_value_init(&number, G_TYPE_INT);
    g_value_transform(&value, &number);
    return g_value_get_int(&number);
  }

  GstElement* const pipeline_;
  GstElement* const feed_;
  GstElement* const out_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<CameraServer>> CameraServer::Start(const cv::Size& size, int port) {
  gst_init(nullptr, nullptr);
  const std::string text = absl::StrCat(
      "appsrc name=feed is-live=true format=time max-bytes=0 caps=video/x-raw,format=GRAY8,width=",
      size.width, ",height=", size.height,
      ",framerate=0/1 ! matroskamux streamable=true ! tcpserversink name=out sync=false "
      "sync-method=next-keyframe host=127.0.0.1 port=",
      port);
  GError* error = nullptr;
  GstElement* pipeline = gst_parse_launch(text.c_str(), &error);
  if (error != nullptr || pipeline == nullptr) {
    const absl::Status status = Missing(error);
    if (error != nullptr) g_error_free(error);
    if (pipeline != nullptr) gst_object_unref(pipeline);
    return status;
  }
  auto server = std::make_unique<MatroskaServer>(pipeline);
  if (!server->Play()) {
    return absl::UnavailableError(absl::StrCat("no camera could be served on port ", port));
  }
  return server;
}

}  // namespace corbslam::tests
