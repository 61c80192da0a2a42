#include "slam/rendering/webp_animation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <webp/mux.h>

namespace corbslam {
namespace {

cv::Mat MakeFrame(int width, int value) {
  return cv::Mat(40, width, CV_8UC3, cv::Scalar(value, 0, 255 - value));
}

TEST(WebpAnimationTest, HoldsItsFrames) {
  absl::StatusOr<WebpAnimation> animation = WebpAnimation::Create(10);
  ASSERT_TRUE(animation.ok()) << animation.status();
  for (const int value : {0, 100, 200}) {
    const absl::Status added = animation->Add(MakeFrame(60, value));
    ASSERT_TRUE(added.ok()) << added;
  }
  const absl::StatusOr<std::string> bytes = animation->Finish();
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const WebPData data{reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size()};
  WebPMux* mux = WebPMuxCreate(&data, 0);
  ASSERT_NE(mux, nullptr);
  int frames = 0;
  int width = 0;
  int height = 0;
  EXPECT_EQ(WebPMuxNumChunks(mux, WEBP_CHUNK_ANMF, &frames), WEBP_MUX_OK);
  EXPECT_EQ(WebPMuxGetCanvasSize(mux, &width, &height), WEBP_MUX_OK);
  EXPECT_EQ(frames, 3);
  EXPECT_EQ(width, 60);
  EXPECT_EQ(height, 40);
  WebPMuxFrameInfo info;
  ASSERT_EQ(WebPMuxGetFrame(mux, 1, &info), WEBP_MUX_OK);
  EXPECT_EQ(info.duration, 100);
  WebPDataClear(&info.bitstream);
  WebPMuxDelete(mux);
}

TEST(WebpAnimationTest, RefusesWhatItCantHold) {
  EXPECT_EQ(WebpAnimation::Create(4).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(WebpAnimation::Create(21).status().code(), absl::StatusCode::kInvalidArgument);
  absl::StatusOr<WebpAnimation> animation = WebpAnimation::Create(5);
  ASSERT_TRUE(animation.ok());
  EXPECT_EQ(animation->Finish().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(animation->Add({}).code(), absl::StatusCode::kInvalidArgument);
  ASSERT_TRUE(animation->Add(MakeFrame(60, 0)).ok());
  EXPECT_EQ(animation->Add(MakeFrame(61, 0)).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace corbslam
