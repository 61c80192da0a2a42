#include "slam/sensor/sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

namespace corbslam {
namespace {

using ::testing::HasSubstr;

const Camera kCamera = {.fx_px = 500,
                        .fy_px = 500,
                        .cx_px = 320,
                        .cy_px = 240,
                        .width_px = 640,
                        .height_px = 480,
                        .baseline_m = 0.1,
                        .close_depth_m = 4};

// Draws random discs at a sub-pixel position: the same scene seen `shift_px` further left.
cv::Mat Scene(double shift_px) {
  constexpr int kFractionBits = 6;
  std::mt19937_64 random(11);
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 1500; ++i) {
    const double x = static_cast<double>(random() % 80000) / 100 - shift_px;
    const double y = static_cast<double>(random() % 48000) / 100;
    const double radius = 2 + static_cast<double>(random() % 1000) / 100;
    const auto fixed = [](double v) { return static_cast<int>(std::lround(v * 64)); };
    cv::circle(image, {fixed(x), fixed(y)}, fixed(radius),
               cv::Scalar(static_cast<double>(random() % 256)), cv::FILLED, cv::LINE_AA,
               kFractionBits);
  }
  cv::GaussianBlur(image, image, {5, 5}, 1.0);
  return image;
}

std::unique_ptr<Sensor> Stereo(bool parallel = true) {
  auto sensor = MakeSensor(StereoCalibration{.camera = kCamera, .raw = {}},
                           {.orb = {.features = 1000}, .parallel = parallel});
  EXPECT_TRUE(sensor.ok()) << sensor.status();
  return *std::move(sensor);
}

std::vector<double> DisparityErrors(const Features& features, double truth_px) {
  std::vector<double> errors;
  for (const Keypoint& keypoint : features.keypoints) {
    if (keypoint.HasDepth()) errors.push_back(std::abs(keypoint.disparity_px - truth_px));
  }
  std::ranges::sort(errors);
  return errors;
}

TEST(StereoSensorTest, MeasuresDisparitiesBelowAPixel) {
  const auto sensor = Stereo();
  for (const double truth_px : {3.25, 12.5, 30.8}) {
    const auto features = sensor->Process({.grey = Scene(0), .right = Scene(truth_px)});
    ASSERT_TRUE(features.ok()) << features.status();
    const std::vector<double> errors = DisparityErrors(*features, truth_px);
    ASSERT_GT(errors.size(), features->keypoints.size() / 2) << truth_px;
    EXPECT_LT(errors[errors.size() / 2], 0.08) << truth_px;
    EXPECT_LT(errors[errors.size() * 9 / 10], 0.35) << truth_px;
  }
}

// The right camera's principal point lies further right, or left: its picture is moved by as much.
TEST(StereoSensorTest, HonoursAnotherPrincipalColumnOfTheRightCamera) {
  constexpr double kTruth_px = 12.5;
  // No offset moves the picture by whole columns: half of the patches would then match to the last
  // bit, and the others, though right, be left out as worse than the median.
  for (const double offset_px : {10.0, -7.0, 40.0, 3.25, -0.75}) {
    const auto sensor =
        MakeSensor(StereoCalibration{.camera = kCamera, .raw = {}, .right_cx_offset_px = offset_px},
                   {.orb = {.features = 1000}, .parallel = true});
    ASSERT_TRUE(sensor.ok()) << sensor.status();
    const auto features =
        (*sensor)->Process({.grey = Scene(0), .right = Scene(kTruth_px - offset_px)});
    ASSERT_TRUE(features.ok()) << features.status();
    const std::vector<double> errors = DisparityErrors(*features, kTruth_px);
    ASSERT_GT(errors.size(), features->keypoints.size() / 2) << offset_px;
    EXPECT_LT(errors[errors.size() / 2], 0.08) << offset_px;
  }
}

TEST(StereoSensorTest, RefusesAPrincipalColumnOutsideThePicture) {
  for (const double offset_px : {640.0, -1000.0, std::numeric_limits<double>::quiet_NaN()}) {
    const auto sensor = MakeSensor(
        StereoCalibration{.camera = kCamera, .raw = {}, .right_cx_offset_px = offset_px}, {});
    EXPECT_THAT(std::string(sensor.status().message()), HasSubstr("right_cx_offset_px"));
  }
}

TEST(StereoSensorTest, ExchangedCamerasGiveNoDisparities) {
  const auto features = Stereo()->Process({.grey = Scene(20), .right = Scene(0)});
  ASSERT_TRUE(features.ok());
  // A tenth may match by chance.
  EXPECT_LT(DisparityErrors(*features, 20).size(), features->keypoints.size() / 10);
}

TEST(StereoSensorTest, APointAtInfinityHasTheLeastDisparity) {
  const auto features = Stereo()->Process({.grey = Scene(0), .right = Scene(0)});
  ASSERT_TRUE(features.ok());
  const std::vector<double> errors = DisparityErrors(*features, 0);
  ASSERT_GT(errors.size(), features->keypoints.size() / 2);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.05);
}

TEST(StereoSensorTest, ADifferenceOfExposureDoesNotMatter) {
  cv::Mat right = Scene(12.5);
  right.convertTo(right, CV_8UC1, 1.0, 12);
  const auto features = Stereo()->Process({.grey = Scene(0), .right = right});
  ASSERT_TRUE(features.ok());
  const std::vector<double> errors = DisparityErrors(*features, 12.5);
  ASSERT_GT(errors.size(), features->keypoints.size() / 2);
  EXPECT_LT(errors[errors.size() / 2], 0.08);
}

// The right picture of a scene, which lies lower than the calibration says.
cv::Mat Lower(double shift_px, double rows_px) {
  cv::Mat lower;
  cv::warpAffine(Scene(shift_px), lower, cv::Matx23d(1, 0, 0, 0, 1, rows_px), {640, 480},
                 cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return lower;
}

double MeanError(const Features& features, double truth_px) {
  const std::vector<double> errors = DisparityErrors(features, truth_px);
  double sum = 0;
  for (const double error : errors) sum += std::min(error, 1.0);
  return sum / static_cast<double>(std::max<size_t>(1, errors.size()));
}

TEST(StereoSensorTest, PutsRowsRightThatAreOffByAPart) {
  constexpr double kTruth_px = 12.5;
  for (const double rows_px : {0.4, -0.4}) {
    const auto sensor = Stereo();
    const SensorImages pair = {.grey = Scene(0), .right = Lower(kTruth_px, rows_px)};
    const auto before = sensor->Process(pair);
    ASSERT_TRUE(before.ok()) << before.status();
    for (int i = 0; i < 40; ++i) ASSERT_TRUE(sensor->Process(pair).ok());
    EXPECT_NEAR(sensor->row_correction_px(), rows_px, 0.06);
    const auto after = sensor->Process(pair);
    ASSERT_TRUE(after.ok()) << after.status();
    EXPECT_LT(MeanError(*after, kTruth_px), 0.9 * MeanError(*before, kTruth_px)) << rows_px;
  }
}

TEST(StereoSensorTest, RowsThatAgreeStayAsTheyAre) {
  const auto sensor = Stereo();
  const SensorImages pair = {.grey = Scene(0), .right = Scene(12.5)};
  const auto before = sensor->Process(pair);
  ASSERT_TRUE(before.ok()) << before.status();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(sensor->Process(pair).ok());
  EXPECT_EQ(sensor->row_correction_px(), 0);
  EXPECT_EQ(sensor->Process(pair)->keypoints, before->keypoints);
}

TEST(StereoSensorTest, ThreadsDoNotChangeTheResult) {
  const SensorImages images = {.grey = Scene(0), .right = Scene(7.7)};
  const auto one = Stereo(false)->Process(images);
  const auto sensor = Stereo(true);
  for (int i = 0; i < 3; ++i) {
    const auto two = sensor->Process(images);
    ASSERT_TRUE(one.ok() && two.ok());
    EXPECT_EQ(one->keypoints, two->keypoints);
    EXPECT_EQ(one->descriptors, two->descriptors);
  }
}

TEST(StereoSensorTest, RefusesWrongImages) {
  const auto sensor = Stereo();
  const cv::Mat right_size(480, 640, CV_8UC1, cv::Scalar(0));
  const cv::Mat wrong_size(240, 320, CV_8UC1, cv::Scalar(0));
  const absl::Status status = sensor->Process({.grey = right_size, .right = wrong_size}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("right image: expected 640x480 CV_8UC1"));
  EXPECT_THAT(status.message(), HasSubstr("320x240"));
  EXPECT_THAT(sensor->Process({.grey = right_size}).status().message(), HasSubstr("no image"));
}

TEST(StereoSensorTest, RefusesACameraWithoutBaseline) {
  Camera camera = kCamera;
  camera.baseline_m = 0;
  EXPECT_THAT(MakeSensor(StereoCalibration{.camera = camera, .raw = {}}, {}).status().message(),
              HasSubstr("baseline_m is 0"));
}

TEST(RgbdSensorTest, ReadsDepthInUnitsAndInMetres) {
  const auto sensor = MakeSensor(RgbdCalibration{.camera = kCamera, .lens = {}}, {});
  ASSERT_TRUE(sensor.ok());
  // The depth is 2 m on the left, and there is none on the right.
  cv::Mat units(480, 640, CV_16UC1, cv::Scalar(10000));
  units.colRange(320, 640).setTo(0);
  cv::Mat metres(480, 640, CV_32FC1, cv::Scalar(2));
  metres.colRange(320, 640).setTo(std::numeric_limits<float>::quiet_NaN());
  for (const cv::Mat& depth : {units, metres}) {
    const auto features = (*sensor)->Process({.grey = Scene(0), .depth = depth});
    ASSERT_TRUE(features.ok()) << features.status();
    ASSERT_GT(features->keypoints.size(), 500U);
    for (const Keypoint& keypoint : features->keypoints) {
      const bool left = std::lround(keypoint.x_px) < 320;
      // The disparity is 500 * 0.1 / 2.
      EXPECT_FLOAT_EQ(keypoint.disparity_px, left ? 25.0F : 0.0F);
    }
  }
}

TEST(RgbdSensorTest, UndistortsKeypointsAndReadsDepthWhereTheyWereSeen) {
  const RadialTangential distortion = {.k1 = -0.3, .k2 = 0.1};
  const auto ideal = MakeSensor(RgbdCalibration{.camera = kCamera, .lens = {}}, {});
  const auto lens = MakeSensor(RgbdCalibration{.camera = kCamera, .lens = distortion}, {});
  ASSERT_TRUE(ideal.ok() && lens.ok());
  cv::Mat depth(480, 640, CV_16UC1);
  for (int x = 0; x < 640; ++x) depth.col(x).setTo(5000 + 20 * x);
  const auto raw = (*ideal)->Process({.grey = Scene(0), .depth = depth});
  const auto undistorted = (*lens)->Process({.grey = Scene(0), .depth = depth});
  ASSERT_TRUE(raw.ok() && undistorted.ok());
  ASSERT_EQ(raw->keypoints.size(), undistorted->keypoints.size());
  for (size_t i = 0; i < raw->keypoints.size(); ++i) {
    const Eigen::Vector2d pixel =
        UndistortPixel(kCamera, distortion, raw->keypoints[i].Pixel()).value();
    EXPECT_NEAR((pixel - undistorted->keypoints[i].Pixel()).norm(), 0, 1e-3);
    EXPECT_EQ(raw->keypoints[i].disparity_px, undistorted->keypoints[i].disparity_px);
  }
}

TEST(RgbdSensorTest, ThreadsDoNotChangeTheResult) {
  const RgbdCalibration calibration = {.camera = kCamera,
                                       .lens = RadialTangential{.k1 = -0.3, .k2 = 0.1}};
  cv::Mat depth(480, 640, CV_16UC1);
  for (int x = 0; x < 640; ++x) depth.col(x).setTo(5000 + 20 * x);
  const SensorImages images = {.grey = Scene(0), .depth = depth};
  const auto one = MakeSensor(calibration, {.parallel = false}).value()->Process(images);
  const auto sensor = MakeSensor(calibration, {.parallel = true}).value();
  for (int i = 0; i < 3; ++i) {
    const auto two = sensor->Process(images);
    ASSERT_TRUE(one.ok() && two.ok());
    EXPECT_EQ(one->keypoints, two->keypoints);
    EXPECT_EQ(one->descriptors, two->descriptors);
  }
}

// One camera sees what an RGB-D camera does, but for depths.
TEST(MonocularSensorTest, FindsTheSameFeaturesWithoutDepths) {
  const RgbdCalibration rgbd = {.camera = kCamera, .lens = RadialTangential{.k1 = -0.3, .k2 = 0.1}};
  const MonocularCalibration one = FirstCameraOf(rgbd);
  EXPECT_EQ(KindOf(one), SensorKind::kMonocular);
  EXPECT_FALSE(one.camera.IsMetric());
  const auto with_depth = MakeSensor(rgbd, {}).value()->Process(
      {.grey = Scene(0), .depth = cv::Mat(480, 640, CV_16UC1, cv::Scalar(5000))});
  const auto sensor = MakeSensor(one, {});
  ASSERT_TRUE(sensor.ok()) << sensor.status();
  EXPECT_FALSE((*sensor)->camera().IsMetric());
  const auto alone = (*sensor)->Process({.grey = Scene(0)});
  ASSERT_TRUE(with_depth.ok() && alone.ok());
  ASSERT_GT(alone->keypoints.size(), 500U);
  EXPECT_EQ(alone->descriptors, with_depth->descriptors);
  for (size_t i = 0; i < alone->keypoints.size(); ++i) {
    EXPECT_EQ(alone->keypoints[i].Pixel(), with_depth->keypoints[i].Pixel());
    EXPECT_FALSE(alone->keypoints[i].HasDepth());
  }
}

TEST(MonocularSensorTest, RefusesABaselineAndOtherPictures) {
  EXPECT_THAT(MakeSensor(MonocularCalibration{.camera = kCamera}, {}).status().message(),
              HasSubstr("must be 0 for one camera alone"));
  const auto sensor = MakeSensor(FirstCameraOf(StereoCalibration{.camera = kCamera}), {});
  ASSERT_TRUE(sensor.ok());
  EXPECT_THAT((*sensor)->Process({.grey = cv::Mat(48, 64, CV_8UC1)}).status().message(),
              HasSubstr("64x48"));
}

TEST(FirstCameraTest, OfARawPairIsTheLeftOneAsItRecords) {
  StereoCalibration pair;
  pair.raw.emplace();
  pair.raw->left = {300, 301, 320, 240, Equidistant{.k1 = 0.01}};
  pair.raw->right = pair.raw->left;
  pair.raw->right_from_left.translation = {-0.1, 0, 0};
  pair.raw->width_px = 640;
  pair.raw->height_px = 480;
  pair.body_from_raw_left = Rigid3d{Eigen::Quaterniond::Identity(), {1, 2, 3}};
  const MonocularCalibration left = FirstCameraOf(pair);
  EXPECT_EQ(left.camera.fy_px, 301);
  EXPECT_EQ(left.camera.width_px, 640);
  EXPECT_EQ(left.camera.baseline_m, 0);
  EXPECT_EQ(std::get<Equidistant>(left.lens).k1, 0.01);
  EXPECT_EQ(left.body_from_raw->translation.z(), 3);
  EXPECT_EQ(RecordedCameraOf(left)->lens.fx_px, 300);
  EXPECT_EQ(RecordedCameraOf(left)->camera_from_recorded.translation, Eigen::Vector3d::Zero());
}

TEST(RgbdSensorTest, RefusesWrongDepthImages) {
  const auto sensor = MakeSensor(RgbdCalibration{.camera = kCamera, .lens = {}}, {});
  ASSERT_TRUE(sensor.ok());
  const auto result =
      (*sensor)->Process({.grey = Scene(0), .depth = cv::Mat(480, 640, CV_8UC1, cv::Scalar(1))});
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(result.status().message(), HasSubstr("CV_8UC1"));
}

TEST(StereoSensorTest, RecordedStreetHasPlausibleDepths) {
  const char* const folder = std::getenv("CORBSLAM_DATA_DIR");
  if (folder == nullptr) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "CORBSLAM_DATA_DIR must be set";
    GTEST_SKIP() << "CORBSLAM_DATA_DIR is not set";
  }
  const std::string sequence = std::string(folder) + "/kitti_00_first201";
  const cv::Mat left = cv::imread(sequence + "/image_0/000100.png", cv::IMREAD_GRAYSCALE);
  const cv::Mat right = cv::imread(sequence + "/image_1/000100.png", cv::IMREAD_GRAYSCALE);
  const Camera camera = {.fx_px = 718.856,
                         .fy_px = 718.856,
                         .cx_px = 607.1928,
                         .cy_px = 185.2157,
                         .width_px = 1241,
                         .height_px = 376,
                         .baseline_m = 0.53716,
                         .close_depth_m = 18.8};
  const auto sensor = MakeSensor(StereoCalibration{.camera = camera, .raw = {}}, {});
  ASSERT_TRUE(sensor.ok());
  const auto features = (*sensor)->Process({.grey = left, .right = right});
  ASSERT_TRUE(features.ok()) << features.status();
  int with_depth = 0;
  int below_street = 0;
  for (const Keypoint& keypoint : features->keypoints) {
    if (!keypoint.HasDepth()) continue;
    ++with_depth;
    // The camera is 1.65 m above the street: nothing is seen much below it.
    const Eigen::Vector3d point = Unproject(camera, keypoint.x_px, keypoint.y_px,
                                            DepthFromDisparity(camera, keypoint.disparity_px));
    below_street += point.y() > 2.5 && point.z() < 30;
  }
  EXPECT_GT(with_depth, 1000);
  EXPECT_LT(below_street, with_depth / 50);
}

// A fisheye's keypoints far from the axis have no place in a pinhole's picture.
TEST(SensorTest, AFisheyesEdgeIsLeftOut) {
  const Equidistant fisheye = {0.01, 0, 0, 0};
  Camera wide = kCamera;
  wide.fx_px = wide.fy_px = 170;
  const auto sensor = MakeSensor(RgbdCalibration{.camera = wide, .lens = fisheye}, {});
  ASSERT_TRUE(sensor.ok()) << sensor.status();
  const cv::Mat depth(480, 640, CV_16UC1, cv::Scalar(10000));
  const auto features = (*sensor)->Process({.grey = Scene(0), .depth = depth});
  ASSERT_TRUE(features.ok()) << features.status();
  EXPECT_GT(features->keypoints.size(), 500u);
  EXPECT_EQ(features->keypoints.size(), features->descriptors.size());
  const double farthest_px = 170 * std::tan(81 * 3.14159 / 180);
  for (const Keypoint& keypoint : features->keypoints) {
    EXPECT_LT((keypoint.Pixel() - Eigen::Vector2d(320, 240)).norm(), farthest_px);
  }
}

TEST(SensorTest, NothingIsFoundWhereTheMaskIsBlack) {
  cv::Mat mask(480, 640, CV_8UC1, cv::Scalar(255));
  mask.rowRange(300, 480).setTo(0);
  const cv::Mat depth(480, 640, CV_16UC1, cv::Scalar(10000));
  const auto rgbd = MakeSensor(RgbdCalibration{.camera = kCamera, .mask = mask}, {});
  const auto stereo = MakeSensor(StereoCalibration{.camera = kCamera, .mask = mask}, {});
  ASSERT_TRUE(rgbd.ok() && stereo.ok()) << rgbd.status() << stereo.status();
  for (const auto& features : {(*rgbd)->Process({.grey = Scene(0), .depth = depth}),
                               (*stereo)->Process({.grey = Scene(0), .right = Scene(6)})}) {
    ASSERT_TRUE(features.ok()) << features.status();
    // As many as without a mask: those that it hides leave their places to others.
    EXPECT_GT(features->keypoints.size(), 1900u);
    for (const Keypoint& keypoint : features->keypoints) EXPECT_LT(keypoint.y_px, 301);
  }
  const auto bad =
      MakeSensor(StereoCalibration{.camera = kCamera, .mask = mask.rowRange(0, 100)}, {});
  EXPECT_THAT(std::string(bad.status().message()), HasSubstr("mask image: expected 640x480"));
}

}  // namespace
}  // namespace corbslam
