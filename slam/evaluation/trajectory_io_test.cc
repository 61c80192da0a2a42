#include "slam/evaluation/trajectory_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "slam/evaluation/pose_header.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

std::string Write(const std::string& name, const std::string& text) {
  const std::string path = ::testing::TempDir() + "trajectory_io_" + name;
  std::ofstream(path) << text;
  return path;
}

Trajectory MakeTrajectory() {
  Trajectory trajectory(2);
  trajectory[0].timestamp_ns = 1305031102175304001;
  trajectory[0].world_from_camera.translation = {1, -2, 3.5};
  trajectory[1].timestamp_ns = 1305031102275304000;
  trajectory[1].world_from_camera.rotation = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
  return trajectory;
}

void ExpectSame(const Trajectory& a, const Trajectory& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].timestamp_ns, b[i].timestamp_ns);
    const Rigid3d difference = a[i].world_from_camera.Inverse() * b[i].world_from_camera;
    EXPECT_LT(difference.translation.norm(), 1e-8);
    EXPECT_LT(RotationAngle(difference.rotation), 1e-7);
  }
}

TEST(TumTrajectoryTest, ComesBackAsWritten) {
  const std::string path = ::testing::TempDir() + "trajectory_io_round.tum";
  ASSERT_TRUE(WriteTumTrajectory(MakeTrajectory(), path).ok());
  const absl::StatusOr<Trajectory> read = ReadTumTrajectory(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSame(*read, MakeTrajectory());
}

TEST(TumTrajectoryTest, NamesTheLineAndTheField) {
  const std::string path = Write("bad.tum", "# comment\n1 0 0 0 0 0 0 1\n2 0 0 x 0 0 0 1\n");
  const absl::Status status = ReadTumTrajectory(path).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr(path + ":3: field 4"));
}

TEST(TumTrajectoryTest, RefusesAQuaternionOfWrongLength) {
  EXPECT_THAT(
      std::string(ReadTumTrajectory(Write("q.tum", "1 0 0 0 0 0 0 2\n")).status().message()),
      HasSubstr(":1: quaternion of length 2"));
}

TEST(TumTrajectoryTest, NamesAFileThatIsNotThere) {
  EXPECT_EQ(ReadTumTrajectory("/nowhere/x.tum").status().code(), absl::StatusCode::kNotFound);
}

TEST(TumTrajectoryTest, SaysWhatIsNotFiniteRepeatsOrGoesBack) {
  const std::string path = Write("rows.tum",
                                 "# header\n"
                                 "3 0 0 0 0 0 0 1\n"
                                 "1 1 0 0 0 0 0 1\n"
                                 "2 nan 0 0 0 0 0 1\n"
                                 "2 inf 0 0 0 0 0 1\n"
                                 "nan 0 0 0 0 0 0 1\n"
                                 "3 9 0 0 0 0 0 1\n");
  const auto read = ReadTumFile(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->trajectory.size(), 2u);
  EXPECT_EQ(read->trajectory[0].timestamp_ns, 1'000'000'000);
  EXPECT_EQ(read->trajectory[1].world_from_camera.translation.x(), 0);
  EXPECT_EQ(read->rows_not_finite, 3u);
  EXPECT_EQ(read->rows_repeated, 1u);
  EXPECT_EQ(read->rows_out_of_order, 1u);
  ASSERT_EQ(read->notes.size(), 3u);
  EXPECT_THAT(read->notes[0], HasSubstr(path + ": 3 rows left out"));
  EXPECT_THAT(read->notes[0], HasSubstr("line 4"));
  EXPECT_THAT(read->notes[1], HasSubstr("1 row left out: an earlier row has the same time"));
  EXPECT_THAT(read->notes[1], HasSubstr("line 7"));
  EXPECT_THAT(read->notes[2], HasSubstr("line 3"));
  // A reader that needs every row names the first one that holds no pose.
  EXPECT_THAT(std::string(ReadTumTrajectory(path).status().message()), HasSubstr("line 4"));
}

struct TumForm {
  const char* name;
  const char* text;
};
class TumFormsTest : public ::testing::TestWithParam<TumForm> {};

TEST_P(TumFormsTest, IsReadAsTheSame) {
  const std::string path = Write(std::string("form_") + GetParam().name, GetParam().text);
  const auto read = ReadTumFile(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->trajectory.size(), 1u);
  EXPECT_EQ(read->trajectory[0].timestamp_ns, 1305031102175304001);
  EXPECT_EQ(read->trajectory[0].world_from_camera.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read->trajectory[0].world_from_camera.rotation.w(), 0);
  EXPECT_EQ(read->trajectory[0].world_from_camera.rotation.x(), 1);
  EXPECT_TRUE(read->notes.empty());
}

INSTANTIATE_TEST_SUITE_P(
    AllForms, TumFormsTest,
    ::testing::Values(
        TumForm{"Plain", "1305031102.175304001 1 2 3 1 0 0 0\n"},
        TumForm{"Commas", "1305031102.175304001,1,2,3,1,0,0,0\n"},
        TumForm{"CommasAndSpaces", "1305031102.175304001, 1, 2, 3, 1, 0, 0, 0\r\n"},
        TumForm{"Tabs", "1305031102.175304001\t1\t2\t3\t1\t0\t0\t0"},
        TumForm{"Nanoseconds", "1305031102175304001 1 2 3 1 0 0 0\n"},
        TumForm{"HeaderWithoutHash",
                "timestamp tx ty tz qx qy qz qw\n1305031102.175304001 1 2 3 1 0 0 0\n"},
        TumForm{"HeaderWithWFirst",
                "timestamp,tx,ty,tz,qw,qx,qy,qz\n1305031102.175304001,1,2,3,0,1,0,0\n"},
        TumForm{"ByteOrderMark", "\xef\xbb\xbf# t\n1305031102.175304001 1 2 3 1 0 0 0 # first\n"},
        TumForm{"ByteOrderMarkAndRow", "\xef\xbb\xbf\n1305031102.175304001 1 2 3 1 0 0 0\n"}),
    [](const auto& info) { return info.param.name; });

TEST(TumTrajectoryTest, SaysWhatItsPosesAreOf) {
  const std::string path = ::testing::TempDir() + "trajectory_io_body.tum";
  ASSERT_TRUE(
      WriteTumTrajectory(MakeTrajectory(), path, PoseHeaderLine(PosesOf::kBody) + "; more").ok());
  const auto read = ReadTumFile(path);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->poses_of, PosesOf::kBody);
  ExpectSame(read->trajectory, MakeTrajectory());
  EXPECT_FALSE(ReadTumFile(Write("none.tum", "1 0 0 0 0 0 0 1\n"))->poses_of.has_value());
}

TEST(TumTrajectoryTest, RefusesARowThatIsHalfAHeader) {
  EXPECT_FALSE(ReadTumFile(Write("half.tum", "x 0 0 0 0 0 0 1\n")).ok());
  EXPECT_FALSE(ReadTumFile(Write("micro.tum", "1305031102175304 0 0 0 0 0 0 1\n")).ok());
}

TEST(KittiTrajectoryTest, LeavesOutWhatIsNotFiniteAndKeepsTheTimes) {
  const auto read = ReadKittiFile(Write("gap.txt",
                                        "1 0 0 0 0 1 0 0 0 0 1 0\n"
                                        "nan 0 0 0 0 1 0 0 0 0 1 0\n"
                                        "1 0 0 0 0 1 0 0 0 0 1 5\n"),
                                  Write("gap_times.txt", "0\n0.1\n0.2\n"));
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->trajectory.size(), 2u);
  EXPECT_EQ(read->trajectory[1].timestamp_ns, 200'000'000);
  EXPECT_EQ(read->trajectory[1].world_from_camera.translation.z(), 5);
  EXPECT_EQ(read->rows_not_finite, 1u);
}

TEST(KittiTrajectoryTest, ComesBackAsWrittenWithItsTimes) {
  const std::string poses = ::testing::TempDir() + "trajectory_io_poses.txt";
  ASSERT_TRUE(WriteKittiTrajectory(MakeTrajectory(), poses).ok());
  const std::string times = Write("times.txt", "1305031102.175304001\n1305031102.275304\n");
  const absl::StatusOr<Trajectory> read = ReadKittiTrajectory(poses, times);
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSame(*read, MakeTrajectory());
}

TEST(KittiTrajectoryTest, TakesTenHertzWithoutTimes) {
  const absl::StatusOr<Trajectory> read =
      ReadKittiTrajectory(Write("two.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 5\n"));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ((*read)[1].timestamp_ns, 100'000'000);
  EXPECT_EQ((*read)[1].world_from_camera.translation.z(), 5);
}

TEST(KittiTrajectoryTest, RefusesAnotherNumberOfTimes) {
  const std::string poses = Write("one.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_FALSE(ReadKittiTrajectory(poses, Write("two_times.txt", "0\n0.1\n")).ok());
}

TEST(KittiTrajectoryTest, RefusesWhatIsNoRotation) {
  EXPECT_FALSE(ReadKittiTrajectory(Write("no.txt", "2 0 0 0 0 1 0 0 0 0 1 0\n")).ok());
  // The matrices are a mirror, and one whose products are infinite, so that their differences are
  // no numbers.
  EXPECT_FALSE(ReadKittiTrajectory(Write("mirror.txt", "-1 0 0 0 0 1 0 0 0 0 1 0\n")).ok());
  EXPECT_FALSE(
      ReadKittiTrajectory(Write("huge.txt", "1e200 1e200 0 0 1e200 -1e200 0 0 0 0 1 0\n")).ok());
}

TEST(EurocTrajectoryTest, MovesTheBodyToTheCamera) {
  // The body is turned by 180 degrees about z; the camera sits 0.1 m ahead on the body's x.
  const std::string path =
      Write("data.csv", "#timestamp,...\n1403715273262142976,1,2,3,0,0,0,1,9,9,9\n");
  const Rigid3d body_from_camera{Eigen::Quaterniond::Identity(), {0.1, 0, 0}};
  const absl::StatusOr<Trajectory> read = ReadEurocTrajectory(path, body_from_camera);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ((*read)[0].timestamp_ns, 1403715273262142976);
  EXPECT_LT(((*read)[0].world_from_camera.translation - Eigen::Vector3d(0.9, 2, 3)).norm(), 1e-12);
}

}  // namespace
}  // namespace corbslam
