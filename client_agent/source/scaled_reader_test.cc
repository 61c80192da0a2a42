#include "client_agent/source/scaled_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

// Gives one frame.
class OneFrame : public FrameReader {
 public:
  OneFrame(SensorCalibration calibration, SensorImages images)
      : calibration_(std::move(calibration)), images_(std::move(images)) {
    DescribeCamera(calibration_, description_);
  }
  const SensorCalibration& calibration() const override { return calibration_; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return 1; }
  int64_t timestamp_ns(size_t) const override { return 7; }
  int drive(size_t) const override { return 0; }
  absl::StatusOr<SensorImages> Read(size_t) const override { return images_; }

 private:
  SensorCalibration calibration_;
  SensorImages images_;
  SourceDescription description_;
};

// Black but for a white square whose middle is at (240.5, 120.5).
cv::Mat Square() {
  cv::Mat picture(400, 640, CV_8UC1, cv::Scalar(0));
  picture(cv::Rect(221, 101, 40, 40)).setTo(255);
  return picture;
}

Eigen::Vector2d MiddleOf(const cv::Mat& picture) {
  double x = 0, y = 0, sum = 0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      const double grey = picture.at<uint8_t>(row, column);
      x += grey * column;
      y += grey * row;
      sum += grey;
    }
  }
  return {x / sum, y / sum};
}

// What lies in a direction lies there in the scaled picture, too: to the hundredth of a pixel.
TEST(ScaledReaderTest, PixelsKeepTheirDirections) {
  StereoCalibration stereo;
  stereo.camera = {500, 502, 318, 207, 640, 400, 0.1, 4};
  stereo.right_cx_offset_px = 6;
  stereo.mask = Square();
  const Eigen::Vector2d middle(240.5, 120.5);
  ASSERT_LT((MiddleOf(Square()) - middle).norm(), 1e-9);
  for (const double scale : {0.5, 0.37, 0.75}) {
    const auto reader = ScaleReader(
        std::make_unique<OneFrame>(stereo, SensorImages{7, Square(), Square(), {}}), scale);
    ASSERT_TRUE(reader.ok()) << reader.status();
    const auto& scaled = std::get<StereoCalibration>((*reader)->calibration());
    const auto images = (*reader)->Read(0);
    ASSERT_TRUE(images.ok());
    EXPECT_EQ(images->timestamp_ns, 7);
    EXPECT_EQ(images->grey.cols, scaled.camera.width_px);
    EXPECT_EQ(images->right.rows, scaled.camera.height_px);
    EXPECT_TRUE(images->depth.empty());
    const Eigen::Vector3d direction = Unproject(stereo.camera, middle.x(), middle.y(), 1);
    EXPECT_LT((MiddleOf(images->grey) - Project(scaled.camera, direction)).norm(), 0.02) << scale;
    EXPECT_NEAR(scaled.right_cx_offset_px, 6 * scale, 0.01);
    EXPECT_EQ(scaled.camera.baseline_m, 0.1);
    EXPECT_EQ(scaled.mask.size(), images->grey.size());
    EXPECT_THAT((*reader)->description().layout, HasSubstr("scaled by"));
    EXPECT_EQ((*reader)->description().intrinsics.width_px, scaled.camera.width_px);
  }
}

TEST(ScaledReaderTest, DepthsAreNotMixed) {
  RgbdCalibration rgbd;
  rgbd.camera = {500, 502, 318, 207, 640, 400, 0.08, 4};
  cv::Mat depth(400, 640, CV_16UC1, cv::Scalar(1000));
  depth.colRange(0, 301).setTo(9000);
  const auto reader =
      ScaleReader(std::make_unique<OneFrame>(rgbd, SensorImages{7, Square(), {}, depth}), 0.3);
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto images = (*reader)->Read(0);
  ASSERT_TRUE(images.ok());
  ASSERT_EQ(images->depth.size(), images->grey.size());
  EXPECT_EQ(cv::countNonZero((images->depth == 1000) | (images->depth == 9000)),
            images->depth.rows * images->depth.cols);
}

TEST(ScaledReaderTest, RefusesPicturesThatBecomeTooSmall) {
  StereoCalibration stereo;
  stereo.camera = {500, 502, 318, 207, 640, 400, 0.1, 4};
  const auto reader =
      ScaleReader(std::make_unique<OneFrame>(stereo, SensorImages{7, Square(), Square(), {}}), 0.1);
  EXPECT_THAT(std::string(reader.status().message()), HasSubstr("64x40 pixels"));
}

}  // namespace
}  // namespace corbslam::client_agent
