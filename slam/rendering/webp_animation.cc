#include "slam/rendering/webp_animation.h"

#include <webp/encode.h>
#include <webp/mux.h>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

constexpr int kFirstRate = 5;
constexpr int kLastRate = 20;
constexpr int kLastFrameStays_ms = 2000;

}  // namespace

struct WebpAnimation::Encoder {
  explicit Encoder(int rate) : frames_per_second(rate) {}
  ~Encoder() { WebPAnimEncoderDelete(encoder); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  absl::Status Error(const char* what) const {
    return absl::InternalError(absl::StrCat(
        what, ": ", encoder == nullptr ? "no encoder" : WebPAnimEncoderGetError(encoder)));
  }
  // The time at which a frame begins.
  int Time_ms(size_t frame) const {
    return static_cast<int>(frame * 1000 / static_cast<size_t>(frames_per_second));
  }

  const int frames_per_second;
  WebPAnimEncoder* encoder = nullptr;
  cv::Size size;
  size_t frames = 0;
};

WebpAnimation::WebpAnimation(int frames_per_second)
    : encoder_(std::make_shared<Encoder>(frames_per_second)) {}

absl::StatusOr<WebpAnimation> WebpAnimation::Create(int frames_per_second) {
  if (frames_per_second < kFirstRate || frames_per_second > kLastRate) {
    return absl::InvalidArgumentError(absl::StrCat(frames_per_second, " frames a second, must be ",
                                                   kFirstRate, " to ", kLastRate));
  }
  return WebpAnimation(frames_per_second);
}

absl::Status WebpAnimation::Add(const cv::Mat& image) {
  Encoder& state = *encoder_;
  if (state.frames == kMostFrames) {
    return absl::InvalidArgumentError(
        absl::StrCat("an animation has at most ", kMostFrames, " frames"));
  }
  if (image.empty() || image.type() != CV_8UC3 || image.cols > kLargestSide_px ||
      image.rows > kLargestSide_px || (state.frames > 0 && image.size() != state.size)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a frame of ", image.cols, "x", image.rows, " pixels, must be in colour, up to ",
        kLargestSide_px, " wide and high, and all of one size"));
  }
  if (state.encoder == nullptr) {
    WebPAnimEncoderOptions options;
    if (WebPAnimEncoderOptionsInit(&options) == 0) return state.Error("libwebpmux");
    options.allow_mixed = 0;
    options.minimize_size = 0;
    state.size = image.size();
    state.encoder = WebPAnimEncoderNew(image.cols, image.rows, &options);
  }
  WebPConfig config;
  WebPPicture picture;
  if (state.encoder == nullptr || WebPConfigInit(&config) == 0 ||
      WebPConfigLosslessPreset(&config, 2) == 0 || WebPPictureInit(&picture) == 0) {
    return state.Error("libwebp");
  }
  picture.use_argb = 1;
  picture.width = image.cols;
  picture.height = image.rows;
  const bool is_added =
      WebPPictureImportBGR(&picture, image.data, static_cast<int>(image.step)) != 0 &&
      WebPAnimEncoderAdd(state.encoder, &picture, state.Time_ms(state.frames), &config) != 0;
  WebPPictureFree(&picture);
  if (!is_added) return state.Error("adding a frame");
  ++state.frames;
  return absl::OkStatus();
}

absl::StatusOr<std::string> WebpAnimation::Finish() {
  Encoder& state = *encoder_;
  if (state.frames == 0) return absl::InvalidArgumentError("an animation needs a frame");
  WebPData data;
  WebPDataInit(&data);
  const int end_ms = state.Time_ms(state.frames - 1) + kLastFrameStays_ms;
  if (WebPAnimEncoderAdd(state.encoder, nullptr, end_ms, nullptr) == 0 ||
      WebPAnimEncoderAssemble(state.encoder, &data) == 0) {
    return state.Error("assembling the animation");
  }
  std::string bytes(reinterpret_cast<const char*>(data.bytes), data.size);
  WebPDataClear(&data);
  return bytes;
}

}  // namespace corbslam
