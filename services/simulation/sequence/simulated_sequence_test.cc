#include "services/simulation/sequence/simulated_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <thread>
#include <tuple>

#include "slam/evaluation/trajectory_io.h"

namespace corbslam {
namespace {

// Draws small pictures of a short way.
SimulationSpec SmallCity() {
  SimulationSpec spec;
  spec.seed = 3;
  spec.length_m = 120;
  spec.picture_scale = 0.15;
  return spec;
}

std::unique_ptr<SimulatedSequence> Open(const SimulationSpec& spec) {
  absl::StatusOr<std::unique_ptr<SimulatedSequence>> sequence = SimulatedSequence::Make(spec);
  EXPECT_TRUE(sequence.ok()) << sequence.status();
  return *std::move(sequence);
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         (a.empty() || cv::norm(a, b, cv::NORM_INF) == 0);
}
bool SameBytes(const SensorImages& a, const SensorImages& b) {
  return a.timestamp_ns == b.timestamp_ns && SameBytes(a.grey, b.grey) &&
         SameBytes(a.right, b.right) && SameBytes(a.depth, b.depth);
}

double Contrast(const cv::Mat& image) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  return deviation[0];
}

TEST(SimulatedSequenceTest, DrawsTheSameBytesInAnyOrderAndWithAnyThreads) {
  SimulationSpec spec = SmallCity();
  spec.moving_cars = 2;
  const auto first = Open(spec);
  spec.threads = 2;
  const auto second = Open(spec);
  SensorImages at_once[2];
  std::thread other([&] { at_once[1] = *second->Render(9); });
  at_once[0] = *second->Render(40);
  other.join();
  const SensorImages ninth = *first->Render(9);
  EXPECT_TRUE(SameBytes(ninth, at_once[1]));
  EXPECT_TRUE(SameBytes(*first->Render(40), at_once[0]));
  EXPECT_FALSE(SameBytes(ninth.grey, at_once[0].grey));
  EXPECT_FALSE(SameBytes(ninth.grey, ninth.right));
  EXPECT_GT(Contrast(ninth.grey), 15);
}

TEST(SimulatedSequenceTest, PicturesHaveTheSizeAndTheTimeTheyAreSaidToHave) {
  const auto sequence = Open(SmallCity());
  const Camera& camera = std::get<StereoCalibration>(sequence->calibration()).camera;
  const SensorImages images = *sequence->Render(5);
  EXPECT_EQ(images.timestamp_ns, sequence->timestamp_ns(5));
  EXPECT_EQ(images.timestamp_ns, 500'000'000);
  EXPECT_EQ(images.grey.size(), cv::Size(camera.width_px, camera.height_px));
  EXPECT_EQ(images.right.size(), images.grey.size());
  EXPECT_TRUE(images.depth.empty());
  EXPECT_EQ(sequence->Render(sequence->frame_count()).status().code(),
            absl::StatusCode::kOutOfRange);
}

TEST(SimulatedSequenceTest, NoiseIsOfThePicturesNotOfTheWorld) {
  SimulationSpec spec = SmallCity();
  const SensorImages one = *Open(spec)->Render(5);
  spec.lens.noise_seed = 2;
  const SensorImages other = *Open(spec)->Render(5);
  cv::Mat difference;
  cv::absdiff(one.grey, other.grey, difference);
  EXPECT_GT(cv::mean(difference)[0], 0.2);
  EXPECT_LT(cv::mean(difference)[0], 4);
}

TEST(SimulatedSequenceTest, IsBlackDuringABlackout) {
  SimulationSpec spec = SmallCity();
  spec.blackout = {0.5, 0.2};
  const auto sequence = Open(spec);
  EXPECT_EQ(cv::countNonZero(sequence->Render(5)->grey), 0);
  EXPECT_EQ(cv::countNonZero(sequence->Render(6)->right), 0);
  EXPECT_GT(cv::countNonZero(sequence->Render(7)->grey), 0);
  EXPECT_EQ(sequence->Render(5)->right.size(), sequence->Render(7)->right.size());
}

// Returns the mean rows and columns by which `moved` must be shifted to fit `still`, by normal
// equations of brightness constancy over the whole picture.
cv::Point2d Shift(const cv::Mat& still, const cv::Mat& moved) {
  double xx = 0, xy = 0, yy = 0, xt = 0, yt = 0;
  for (int row = 1; row + 1 < still.rows; ++row) {
    for (int column = 1; column + 1 < still.cols; ++column) {
      const double dx =
          0.5 * (still.at<uint8_t>(row, column + 1) - still.at<uint8_t>(row, column - 1));
      const double dy =
          0.5 * (still.at<uint8_t>(row + 1, column) - still.at<uint8_t>(row - 1, column));
      const double dt = still.at<uint8_t>(row, column) - moved.at<uint8_t>(row, column);
      xx += dx * dx, xy += dx * dy, yy += dy * dy, xt += dx * dt, yt += dy * dt;
    }
  }
  const double determinant = xx * yy - xy * xy;
  return {(yy * xt - xy * yt) / determinant, (xx * yt - xy * xt) / determinant};
}

TEST(SimulatedSequenceTest, CalibrationErrorsMoveTheRightPicture) {
  SimulationSpec spec = SmallCity();
  spec.lens.read_noise = 0;
  spec.lens.shot_noise = 0;
  spec.lens.blur_px = 1.5;
  const SensorImages exact = *Open(spec)->Render(5);
  spec.epipolar_error_px = 0.3;
  spec.disparity_error_px = 0.2;
  const SensorImages off = *Open(spec)->Render(5);
  EXPECT_TRUE(SameBytes(exact.grey, off.grey));
  const cv::Point2d shift = Shift(exact.right, off.right);
  EXPECT_NEAR(shift.y, 0.3, 0.08);
  EXPECT_NEAR(shift.x, 0.2, 0.08);
}

TEST(SimulatedSequenceTest, TurnedSeesTheSamePlacesFromTheOtherSide) {
  SimulationSpec spec = SmallCity();
  const auto forwards = Open(spec);
  spec.turned = true;
  const auto turned = Open(spec);
  const size_t last = forwards->frame_count() - 1;
  for (size_t i = 0; i <= last; i += 7) {
    const Rigid3d there = forwards->world_from_camera(i);
    const Rigid3d back = turned->world_from_camera(last - i);
    EXPECT_LT((there.translation - back.translation).norm(), 1e-9);
    EXPECT_NEAR(RotationAngle(there.rotation.conjugate() * back.rotation), 3.14159265, 1e-6);
  }
}

TEST(SimulatedSequenceTest, FollowsAFileOfPoses) {
  Trajectory poses;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.01 * i, Eigen::Vector3d::UnitY()));
    poses.push_back({int64_t{100'000'000} * i, {turn, Eigen::Vector3d(0.1 * i, 0, 0.8 * i)}});
  }
  SimulationSpec spec = SmallCity();
  spec.world = SimulatedWorld::kPath;
  spec.poses = ::testing::TempDir() + "/simulated_poses.txt";
  ASSERT_TRUE(WriteKittiTrajectory(poses, spec.poses).ok());
  const auto sequence = Open(spec);
  ASSERT_EQ(sequence->frame_count(), 40u);
  const Trajectory truth = TrueTrajectory(*sequence);
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_EQ(truth[i].timestamp_ns, poses[i].timestamp_ns);
    EXPECT_LT(
        (truth[i].world_from_camera.translation - poses[i].world_from_camera.translation).norm(),
        1e-6);
  }
  EXPECT_GT(Contrast(sequence->Render(20)->grey), 15);
  spec.poses = "/nowhere/poses.txt";
  EXPECT_EQ(SimulatedSequence::Make(spec).status().code(), absl::StatusCode::kNotFound);
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

// Of a shutter that takes a whole frame's time to roll, the first rows are those of a picture that
// was taken half a frame earlier, the middle ones those of the frame itself.
TEST(SimulatedSequenceTest, ARollingShutterTakesEachRowAtItsOwnTime) {
  constexpr int kBands = 14;
  SimulationSpec spec = SmallCity();
  spec.lens.read_noise = 0;
  spec.lens.shot_noise = 0;
  spec.lens.blur_px = 0;
  const SensorImages still = *Open(spec)->Render(30);
  const SensorImages before = *[&] {
    SimulationSpec earlier = spec;
    earlier.phase = 0.5 + 0.5 / kBands;
    return Open(earlier)->Render(29);
  }();
  spec.rolling_shutter_ms = 100;
  const auto rolling = Open(spec);
  const SensorImages rolled = *rolling->Render(30);
  ASSERT_EQ(rolled.grey.rows, 4 * kBands);
  EXPECT_EQ(rolled.timestamp_ns, still.timestamp_ns);
  for (const auto& [at_once, earlier, picture] : {std::tuple(still.grey, before.grey, rolled.grey),
                                                  {still.right, before.right, rolled.right}}) {
    const cv::Range first(0, 4);
    const cv::Range middle(26, 30);
    EXPECT_LT(MeanDifference(picture.rowRange(first), earlier.rowRange(first)), 0.5);
    EXPECT_GT(MeanDifference(picture.rowRange(first), at_once.rowRange(first)), 2);
    EXPECT_LT(MeanDifference(picture.rowRange(middle), at_once.rowRange(middle)),
              MeanDifference(picture.rowRange(middle), earlier.rowRange(middle)));
  }
  spec.threads = 3;
  EXPECT_TRUE(SameBytes(rolled, *Open(spec)->Render(30)));
}

TEST(SimulatedSequenceTest, DepthFromAsideIsRegisteredToThePicture) {
  SimulationSpec spec;
  spec.world = SimulatedWorld::kFloor;
  spec.seed = 2;
  spec.picture_scale = 0.25;
  spec.depth_noise_m = 0;
  const cv::Mat ideal = Open(spec)->Render(20)->depth;
  spec.depth_aside_m = 0.06;
  const cv::Mat registered = Open(spec)->Render(20)->depth;
  ASSERT_EQ(registered.size(), ideal.size());
  ASSERT_EQ(registered.type(), CV_16UC1);
  const cv::Mat both = (ideal > 0) & (registered > 0);
  const int common = cv::countNonZero(both);
  EXPECT_GT(common, cv::countNonZero(ideal) * 3 / 4);
  cv::Mat apart;
  cv::absdiff(ideal, registered, apart);
  // Surfaces agree; edges, where a pixel covers both, and walls seen at a slant need not.
  const cv::Mat far_off = (apart > ideal * 0.02) & both;
  EXPECT_LT(cv::countNonZero(far_off), common / 10);
  // Some of what the picture sees lies behind an edge for the other camera, or beside its picture.
  EXPECT_GT(cv::countNonZero((ideal > 0) & (registered == 0)), 0);
}

TEST(SimulatedSequenceTest, RefusesRowsAndDepthsThatARigDoesNotHave) {
  SimulationSpec spec = SmallCity();
  spec.depth_aside_m = 0.05;
  EXPECT_THAT(std::string(SimulatedSequence::Make(spec).status().message()),
              testing::HasSubstr("depth_aside_m=0.05: wants rig=rgbd"));
  spec.depth_aside_m = 0;
  spec.rolling_shutter_ms = 101;
  EXPECT_THAT(std::string(SimulatedSequence::Make(spec).status().message()),
              testing::HasSubstr("rolling_shutter_ms=101"));
  spec.rolling_shutter_ms = 20;
  spec.picture_scale = 1;
  spec.pair.emplace().file = "fish.yaml";
  EXPECT_THAT(std::string(SimulatedSequence::Make(spec).status().message()),
              testing::HasSubstr("fish.yaml"));
}

TEST(SimulatedSequenceTest, FloorsHaveDepth) {
  SimulationSpec spec = SmallCity();
  spec.world = SimulatedWorld::kFloor;
  spec.rooms_x = 2;
  spec.rooms_z = 1;
  spec.picture_scale = 0.25;
  const auto sequence = Open(spec);
  EXPECT_TRUE(std::holds_alternative<RgbdCalibration>(sequence->calibration()));
  EXPECT_EQ(sequence->rate_hz(), 30);
  const SensorImages images = *sequence->Render(30);
  EXPECT_TRUE(images.right.empty());
  ASSERT_EQ(images.depth.type(), CV_16UC1);
  EXPECT_EQ(images.depth.size(), cv::Size(160, 120));
  EXPECT_GT(cv::countNonZero(images.depth), 160 * 120 / 2);
  EXPECT_GT(Contrast(images.grey), 10);
}

}  // namespace
}  // namespace corbslam
