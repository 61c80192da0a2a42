#include "slam/evaluation/trajectory_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace corbslam {
namespace {

namespace fs = std::filesystem;

using ::testing::HasSubstr;

class TrajectoryFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name) << text;
    return folder_ + "/" + name;
  }
  static void ExpectOnePose(const absl::StatusOr<TrajectoryReading>& read, int64_t time_ns) {
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(read->trajectory.size(), 1u);
    const StampedPose& pose = read->trajectory[0];
    EXPECT_EQ(pose.timestamp_ns, time_ns);
    EXPECT_LT((pose.world_from_camera.translation - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
    // The rotation is half a turn about x.
    EXPECT_NEAR(std::abs(pose.world_from_camera.rotation.x()), 1, 1e-12);
  }

  const std::string folder_ = ::testing::TempDir() + "trajectory_file_" +
                              ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(TrajectoryFileTest, KnowsTheFormsByTheirContents) {
  ExpectOnePose(ReadTrajectoryFile(Write("a.txt", "1.5 1 2 3 1 0 0 0\n")), 1'500'000'000);
  ExpectOnePose(ReadTrajectoryFile(Write(
                    "a.csv",
                    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],"
                    "q_RS_y [],q_RS_z []\n1403715273262142976,1,2,3,0,1,0,0\n")),
                1403715273262142976);
  // A recording whose clock began at 0, as KITTI's: nanoseconds of few digits.
  ExpectOnePose(ReadTrajectoryFile(Write("from_zero.csv",
                                         "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],"
                                         "q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n"
                                         "103735900,1,2,3,0,1,0,0\n")),
                103735900);
  // TUM-VI's header has no #.
  ExpectOnePose(ReadTrajectoryFile(
                    Write("b.csv",
                          "timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [],"
                          " q_RS_x [], q_RS_y [], q_RS_z []\n"
                          "1403715273262142976, 1, 2, 3, 0, 1, 0, 0\n")),
                1403715273262142976);
}

TEST_F(TrajectoryFileTest, FindsTheTimesOfKittisForm) {
  const std::string path = Write("alpha.txt", "1 0 0 1 0 -1 0 2 0 0 -1 3\n");
  const absl::Status without = ReadTrajectoryFile(path).status();
  EXPECT_TRUE(absl::IsNotFound(without));
  EXPECT_THAT(std::string(without.message()), HasSubstr("alpha.txt.times"));
  Write("times.txt", "2\n");
  ExpectOnePose(ReadTrajectoryFile(path), 2'000'000'000);
  Write("alpha.txt.times", "3\n");
  ExpectOnePose(ReadTrajectoryFile(path), 3'000'000'000);
  ExpectOnePose(ReadTrajectoryFile(path, Write("other.txt", "4\n")), 4'000'000'000);
}

TEST_F(TrajectoryFileTest, ReadsColmapsImages) {
  const std::string path = Write("images.txt",
                                 "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n"
                                 "1 0 1 0 0 -1 2 3 1 alpha/1500000000.png\n"
                                 "10.5 20.5 -1 30.5 40.5 7\n"
                                 "2 1 nan 0 0 0 0 0 1 alpha/1600000000.png\n"
                                 "\n");
  ExpectOnePose(ReadTrajectoryFile(path), 1'500'000'000);
  ExpectOnePose(ReadTrajectoryFile(folder_), 1'500'000'000);
  EXPECT_EQ(ReadTrajectoryFile(folder_)->rows_not_finite, 1u);
  Write("images.txt", "1 0 1 0 0 -1 2 3 1 alpha/first.png\n\n");
  EXPECT_THAT(std::string(ReadTrajectoryFile(folder_).status().message()),
              HasSubstr("not called after its time"));
}

TEST_F(TrajectoryFileTest, ReadsAPoseAFile) {
  Write("frame-000003.pose.txt", "1\t0\t0\t1\t\n0\t-1\t0\t2\t\n0\t0\t-1\t3\t\n0\t0\t0\t1\t\n");
  Write("frame-000004.pose.txt", "inf 0 0 1\n0 -1 0 2\n0 0 -1 3\n0 0 0 1\n");
  Write("frame-000003.color.png", "");
  ExpectOnePose(ReadTrajectoryFile(folder_), 100'000'000);
  EXPECT_THAT(ReadTrajectoryFile(folder_)->notes.front(), HasSubstr("the first is frame 4"));
  Write("frame-000005.pose.txt", "1 0 0 1\n0 1 0 2\n");
  EXPECT_THAT(std::string(ReadTrajectoryFile(folder_).status().message()),
              HasSubstr("frame-000005.pose.txt has 8 numbers"));
}

TEST_F(TrajectoryFileTest, SaysWhatAFileIsNot) {
  EXPECT_TRUE(absl::IsNotFound(ReadTrajectoryFile(folder_ + "/none.txt").status()));
  EXPECT_THAT(std::string(ReadTrajectoryFile(folder_).status().message()),
              HasSubstr("is a folder without images.txt"));
  EXPECT_THAT(std::string(ReadTrajectoryFile(Write("p.ply", "ply\n")).status().message()),
              HasSubstr("points and no trajectory"));
  EXPECT_THAT(std::string(ReadTrajectoryFile(Write("5.txt", "1 2 3 4 5\n")).status().message()),
              HasSubstr(":1: 5 fields instead of 8"));
  EXPECT_TRUE(ReadTrajectoryFile(Write("empty.txt", ""))->trajectory.empty());
}

}  // namespace
}  // namespace corbslam
