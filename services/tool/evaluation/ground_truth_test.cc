#include "services/tool/evaluation/ground_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "services/simulated_source/simulated_source.h"
#include "services/testing/test_path.h"

namespace corbslam::services {

using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;

namespace {

[[maybe_unused]] const bool registered = RegisterSimulatedSources();

namespace fs = std::filesystem;

using ::testing::HasSubstr;

constexpr char kTwoRows[] = "# time\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n";
constexpr char kTwoMatrices[] = "1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n";
// The camera sits 0.5 m ahead (x) on the body.
constexpr char kSensorYaml[] =
    "camera_model: pinhole\ndistortion_model: radial-tangential\n"
    "T_BS:\n  data: [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
    "resolution: [640, 480]\nintrinsics: [500, 500, 320, 240]\n"
    "distortion_coefficients: [0, 0, 0, 0]\n";

class GroundTruthTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder_); }
  void Write(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(folder_ + "/" + name).parent_path());
    std::ofstream(folder_ + "/" + name) << text;
  }
  absl::StatusOr<std::optional<GroundTruth>> Read(const std::string& layout,
                                                  const std::string& below = "") const {
    return ReadGroundTruth(*ParseSourceSpec(absl::StrCat(layout, ":", folder_, below)));
  }
  // Expects two poses, at x = first_x and first_x + 1.
  void ExpectTwo(const absl::StatusOr<std::optional<GroundTruth>>& truth, double first_x,
                 const std::string& path) const {
    ASSERT_TRUE(truth.ok()) << truth.status();
    ASSERT_TRUE(truth->has_value());
    ASSERT_EQ((*truth)->trajectory.size(), 2u);
    EXPECT_EQ((*truth)->trajectory[0].world_from_camera.translation.x(), first_x);
    EXPECT_THAT((*truth)->path, HasSubstr(path));
    EXPECT_EQ((*truth)->rows_left_out, 0u);
  }

  const std::string folder_ = TestPath("sequence");
};

TEST_F(GroundTruthTest, OfKittiLiesBesideOrInPoses) {
  Write("sequences/04/times.txt", "0\n0.1\n");
  EXPECT_FALSE(Read("kitti", "/sequences/04")->has_value());
  Write("poses/04.txt", kTwoMatrices);
  ExpectTwo(Read("kitti", "/sequences/04"), 1, "poses/04.txt");
  ExpectTwo(Read("kitti", "/sequences/04/"), 1, "poses/04.txt");
  Write("sequences/04/poses.txt", kTwoMatrices);
  ExpectTwo(Read("kitti", "/sequences/04"), 1, "sequences/04/poses.txt");
}

TEST_F(GroundTruthTest, OfTumAndItsLike) {
  Write("rgb.txt", "");
  EXPECT_FALSE(Read("tum")->has_value());
  Write("livingRoom1.gt.freiburg", kTwoRows);
  ExpectTwo(Read("tum"), 1, "livingRoom1.gt.freiburg");
  Write("livingRoom2.gt.freiburg", kTwoRows);
  EXPECT_THAT(std::string(Read("tum").status().message()), HasSubstr("2 files of ground truth"));
  Write("groundtruth.txt", kTwoRows);
  ExpectTwo(Read("tum"), 1, "groundtruth.txt");
}

TEST_F(GroundTruthTest, OfSevenScenesIsAFileAFrame) {
  Write("frame-000000.pose.txt", "1 0 0 1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  Write("frame-000001.pose.txt", "1 0 0 2\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  ExpectTwo(Read("tum"), 1, "sequence");
}

TEST_F(GroundTruthTest, OfEurocAndTumViIsMadeTheCameras) {
  Write("mav0/cam0/sensor.yaml", kSensorYaml);
  EXPECT_FALSE(Read("euroc")->has_value());
  Write("mav0/mocap0/data.csv",
        "timestamp [ns], p_RS_R_x [m], y, z, q_RS_w [], q_RS_x [], y, z\n"
        "1000000000000000000, 1, 0, 0, 1, 0, 0, 0\n"
        "1000000000100000000, 2, 0, 0, 1, 0, 0, 0\n");
  ExpectTwo(Read("euroc"), 1.5, "mocap0");
  Write("mav0/state_groundtruth_estimate0/data.csv",
        "#timestamp,p,p,p,q_w,q_x,q,q\n1000000000000000000,3,0,0,1,0,0,0,9,9,9,9,9,9,9,9,9\n"
        "1000000000100000000,4,0,0,1,0,0,0,9,9,9,9,9,9,9,9,9\n");
  ExpectTwo(Read("euroc"), 3.5, "state_groundtruth_estimate0");
  fs::remove(folder_ + "/mav0/cam0/sensor.yaml");
  EXPECT_THAT(std::string(Read("euroc").status().message()),
              HasSubstr("where the camera sits on it isn't known"));
}

TEST_F(GroundTruthTest, SaysWhatItLeftOut) {
  Write("groundtruth.txt",
        "1 1 0 0 0 0 0 1\n1.1 nan nan nan nan nan nan nan\n2 2 0 0 0 0 0 1\n"
        "2 3 0 0 0 0 0 1\n");
  const auto truth = Read("tum");
  ASSERT_TRUE(truth.ok() && truth->has_value()) << truth.status();
  EXPECT_EQ((*truth)->rows_left_out, 2u);
  ASSERT_EQ((*truth)->notes.size(), 2u);
  EXPECT_THAT((*truth)->notes[0], HasSubstr("groundtruth.txt: 1 row left out"));
  Write("groundtruth.txt", "# nothing\n");
  EXPECT_THAT(std::string(Read("tum").status().message()), HasSubstr("holds no pose"));
}

TEST(TruthOfTest, RefusesABodyThatNobodyKnows) {
  const SourceSpec source = *ParseSourceSpec("sim:city?seed=3&length=200");
  const auto truth = ReadGroundTruth(source);
  ASSERT_TRUE(truth.ok() && truth->has_value()) << truth.status();
  EXPECT_TRUE(absl::IsFailedPrecondition(TruthOf(**truth, source, PosesOf::kBody).status()));
  const auto rectified = TruthOf(**truth, source, PosesOf::kRectifiedCamera);
  ASSERT_TRUE(rectified.ok()) << rectified.status();
  EXPECT_EQ(rectified->size(), (*truth)->trajectory.size());
}

}  // namespace
}  // namespace corbslam::services
