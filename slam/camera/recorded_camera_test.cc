#include "slam/camera/recorded_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "slam/camera/rectification.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

const Rigid3d kTurned{Eigen::Quaterniond(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY())), {}};
const Rigid3d kMounted{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0.1, -0.2, 0.3}};

RecordedCamera MakeRecorded() { return {{500, 501, 320, 240, {}}, kTurned, kMounted}; }

TEST(RecordedCameraTest, TurnsPosesIntoTheFrameThatIsWanted) {
  const RecordedCamera recorded = MakeRecorded();
  EXPECT_FALSE(CameraFromWanted(recorded, PosesOf::kRectifiedCamera)->has_value());
  const Rigid3d camera = **CameraFromWanted(recorded, PosesOf::kRecordedCamera);
  EXPECT_NEAR(RotationAngle(camera.rotation.conjugate() * kTurned.rotation), 0, 1e-12);
  const Rigid3d body = **CameraFromWanted(recorded, PosesOf::kBody);
  // The recorded camera's centre, seen from the body.
  const Eigen::Vector3d centre = body.Inverse() * Eigen::Vector3d::Zero();
  EXPECT_LT((centre - kMounted.translation).norm(), 1e-12);
}

TEST(RecordedCameraTest, LeavesPosesOfPicturesAsRecordedAlone) {
  const Camera camera{500, 500, 320, 240, 640, 480, 0.1, 4};
  EXPECT_FALSE(CameraFromWanted(std::nullopt, PosesOf::kRecordedCamera)->has_value());
  EXPECT_FALSE(CameraFromWanted(AsRecorded(camera), PosesOf::kRecordedCamera)->has_value());
  const Eigen::Vector2d pixel(100, 50);
  EXPECT_LT((RecordedPixel(camera, AsRecorded(camera), pixel) - pixel).norm(), 1e-12);
}

TEST(RecordedCameraTest, SaysThatTheBodyIsNotKnown) {
  const auto status = CameraFromWanted(std::nullopt, PosesOf::kBody).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("T_BS"));
}

TEST(RecordedCameraTest, FindsTheRecordedPixel) {
  RawStereo raw;
  const RadialTangential lens = {-0.2, 0.05, 0.001, -0.002, 0};
  raw.left = {400, 401, 322, 238, lens};
  raw.right = raw.left;
  raw.right_from_left = {kTurned.rotation, {-0.2, 0.01, 0.02}};
  raw.width_px = 640;
  raw.height_px = 480;
  const auto rectifier = StereoRectifier::Make(raw);
  ASSERT_TRUE(rectifier.ok()) << rectifier.status();
  const RecordedCamera recorded{raw.left, rectifier->rectified_from_raw_left(), std::nullopt};
  // A point in the recorded camera's frame, by both ways.
  const Eigen::Vector3d x_in_recorded(0.3, -0.2, 2);
  const Eigen::Vector2d ideal = x_in_recorded.head<2>() / x_in_recorded.z();
  const Eigen::Vector2d bent = Distort(lens, ideal);
  const Eigen::Vector2d expected(400 * bent.x() + 322, 401 * bent.y() + 238);
  const Eigen::Vector2d rectified =
      Project(rectifier->camera(), rectifier->rectified_from_raw_left() * x_in_recorded);
  EXPECT_LT((RecordedPixel(rectifier->camera(), recorded, rectified) - expected).norm(), 1e-9);
}

TEST(RecordedCameraTest, RefusesWhatIsImpossible) {
  EXPECT_TRUE(Validate(MakeRecorded()).ok());
  const auto refused = [](const auto& spoil, const char* field) {
    RecordedCamera recorded = MakeRecorded();
    spoil(recorded);
    const absl::Status status = Validate(recorded);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << field;
    EXPECT_THAT(std::string(status.message()), HasSubstr(field));
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refused([](RecordedCamera& r) { r.lens.fx_px = 0; }, "fx_px");
  refused([](RecordedCamera& r) { r.lens.cy_px = kNan; }, "cy_px");
  refused([](RecordedCamera& r) { r.lens.lens = RadialTangential{.k1 = kNan}; }, "k1");
  refused([](RecordedCamera& r) { r.camera_from_recorded.translation.x() = 1; },
          "camera_from_recorded");
  refused([](RecordedCamera& r) { r.body_from_recorded->translation.x() = kNan; },
          "body_from_recorded");
  refused([](RecordedCamera& r) { r.body_from_recorded->rotation.w() = 3; }, "body_from_recorded");
}

TEST(PosesOfTest, HasNames) {
  for (const PosesOf poses_of :
       {PosesOf::kRecordedCamera, PosesOf::kRectifiedCamera, PosesOf::kBody}) {
    EXPECT_EQ(*ParsePosesOf(ToString(poses_of)), poses_of);
  }
  EXPECT_THAT(std::string(ParsePosesOf("imu").status().message()), HasSubstr("'imu'"));
}

}  // namespace
}  // namespace corbslam
