// Tests a rig both of whose cameras look aside: what is written are poses of the camera that
// recorded, as the truth's are, and not of the rectified one that the map is made of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <filesystem>
#include <numbers>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/frame_reader.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/evaluation/ground_truth.h"
#include "slam/evaluation/trajectory_file.h"
#include "slam/util/text_file.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using client_agent::FrameReader;
using client_agent::FramesOf;
using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::ReadPerturbed;
using client_agent::SourceSpec;
using services::ReadGroundTruth;
using services::RegisterSimulatedSources;
using services::TruthOf;

namespace {

[[maybe_unused]] const bool registered = RegisterSimulatedSources();

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kYaw_rad = 3 * kDegree;

// Pictures of a town whose two cameras were turned to the side, as EuRoC's layout has them.
class TurnedRig {
 public:
  explicit TurnedRig(std::string folder) : folder_(std::move(folder)) {
    drawn_ = *ParseSourceSpec("sim:city?seed=3&length=100&picture_scale=0.4&frames=:60");
    reader_ = *OpenReader(drawn_);
    camera_ = std::get<StereoCalibration>(reader_->calibration()).camera;
    fs::remove_all(folder_);
  }

  void Write() const {
    const Eigen::Vector3d right_in_left =
        turned_from_drawn_ * Eigen::Vector3d(camera_.baseline_m, 0, 0);
    const Rigid3d left_from_right{Eigen::Quaterniond::Identity(), right_in_left};
    WriteCamera(0, body_from_left_);
    WriteCamera(1, body_from_left_ * left_from_right);
    const Trajectory truth = (*ReadGroundTruth(drawn_))->trajectory;
    std::vector<std::string> rows = {"#timestamp,p,p,p,q_w,q_x,q,q"};
    for (const size_t frame : FramesOf(drawn_, reader_->frame_count())) {
      const auto images = ReadPerturbed(*reader_, frame, drawn_.perturbation);
      ASSERT_TRUE(images.ok()) << images.status();
      WritePicture(0, images->timestamp_ns, images->grey);
      WritePicture(1, images->timestamp_ns, images->right);
      const Rigid3d drawn_from_turned{turned_from_drawn_.conjugate(), {0, 0, 0}};
      const Rigid3d pose =
          truth[frame].world_from_camera * drawn_from_turned * body_from_left_.Inverse();
      const Eigen::Vector3d& t = pose.translation;
      const Eigen::Quaterniond& q = pose.rotation;
      rows.push_back(absl::StrFormat("%d,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f", images->timestamp_ns,
                                     t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()));
    }
    const std::string folder = folder_ + "/mav0/state_groundtruth_estimate0";
    fs::create_directories(folder);
    ASSERT_TRUE(WriteLines(rows, folder + "/data.csv").ok());
  }

 private:
  std::string CameraFolder(int camera) const { return absl::StrCat(folder_, "/mav0/cam", camera); }

  void WriteCamera(int number, const Rigid3d& body_from_camera) const {
    fs::create_directories(CameraFolder(number) + "/data");
    const Eigen::Matrix3d r = body_from_camera.rotation.toRotationMatrix();
    const Eigen::Vector3d& t = body_from_camera.translation;
    std::string pose;
    for (int row = 0; row < 3; ++row) {
      absl::StrAppendFormat(&pose, "%.12g, %.12g, %.12g, %.12g, ", r(row, 0), r(row, 1), r(row, 2),
                            t[row]);
    }
    ASSERT_TRUE(
        WriteLines({"camera_model: pinhole", "distortion_model: radial-tangential",
                    "T_BS:", absl::StrCat("  data: [", pose, "0, 0, 0, 1]"),
                    absl::StrFormat("resolution: [%d, %d]", camera_.width_px, camera_.height_px),
                    absl::StrFormat("intrinsics: [%.9g, %.9g, %.9g, %.9g]", camera_.fx_px,
                                    camera_.fy_px, camera_.cx_px, camera_.cy_px),
                    "distortion_coefficients: [0, 0, 0, 0]"},
                   CameraFolder(number) + "/sensor.yaml")
            .ok());
    std::vector<std::string> rows = {"#timestamp [ns],filename"};
    for (const size_t frame : FramesOf(drawn_, reader_->frame_count())) {
      rows.push_back(
          absl::StrFormat("%d,%d.png", reader_->timestamp_ns(frame), reader_->timestamp_ns(frame)));
    }
    ASSERT_TRUE(WriteLines(rows, CameraFolder(number) + "/data.csv").ok());
  }

  // A turn about the centre moves pixels by a homography.
  void WritePicture(int number, int64_t timestamp_ns, const cv::Mat& drawn) const {
    Eigen::Matrix3d k;
    k << camera_.fx_px, 0, camera_.cx_px, 0, camera_.fy_px, camera_.cy_px, 0, 0, 1;
    cv::Mat turned_from_drawn;
    cv::eigen2cv(Eigen::Matrix3d(k * turned_from_drawn_.toRotationMatrix() * k.inverse()),
                 turned_from_drawn);
    cv::Mat turned;
    cv::warpPerspective(drawn, turned, turned_from_drawn, drawn.size(), cv::INTER_LINEAR);
    ASSERT_TRUE(
        cv::imwrite(absl::StrCat(CameraFolder(number), "/data/", timestamp_ns, ".png"), turned));
  }

  const std::string folder_;
  const Eigen::Quaterniond turned_from_drawn_{
      Eigen::AngleAxisd(kYaw_rad, Eigen::Vector3d::UnitY())};
  const Rigid3d body_from_left_{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0.3, -0.1, 0.2}};
  SourceSpec drawn_;
  std::unique_ptr<FrameReader> reader_;
  Camera camera_;
};

// Returns the way from the first pose to the last one, as the first sees it.
Eigen::Vector3d WayOf(const Trajectory& trajectory) {
  return (trajectory.front().world_from_camera.Inverse() * trajectory.back().world_from_camera)
      .translation;
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(a.normalized().dot(b.normalized()));
}

TEST(TurnedRigTest, PosesAreOfTheCameraThatRecorded) {
  const std::string folder = ::testing::TempDir() + "/corbslam_turned_rig";
  TurnedRig(folder).Write();
  if (HasFailure()) return;
  const std::string source = "euroc:" + folder;
  const Mission mission = RunMission({"--source", source, "--robots", "1", "--pace", "step"});
  EXPECT_EQ(mission.report["robots"][0]["tracked"], 61);
  EXPECT_LE(mission.report["robots"][0]["ate_m"], 0.1);

  const SourceSpec spec = *ParseSourceSpec(source);
  const auto truth = ReadGroundTruth(spec);
  ASSERT_TRUE(truth.ok() && truth->has_value()) << truth.status();
  const auto read = ReadTrajectoryFile(mission.folder + "/alpha.local.tum");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->poses_of, PosesOf::kRecordedCamera);
  const Eigen::Vector3d way = WayOf(read->trajectory);
  EXPECT_LT(AngleBetween(way, WayOf((*truth)->trajectory)), 0.5 * kDegree);
  // The rectified camera goes where it looks; the recorded one looks 3 degrees aside.
  const auto rectified = TruthOf(**truth, spec, PosesOf::kRectifiedCamera);
  ASSERT_TRUE(rectified.ok()) << rectified.status();
  EXPECT_NEAR(AngleBetween(way, WayOf(*rectified)), kYaw_rad, 0.5 * kDegree);
  EXPECT_THAT(RunTool({"eval", "--truth", source, mission.folder + "/alpha.local.tum"}),
              ::testing::HasSubstr("alpha.local.tum"));
}

}  // namespace
}  // namespace corbslam::tests
