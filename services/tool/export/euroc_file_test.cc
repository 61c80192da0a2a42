#include "services/tool/export/euroc_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "services/testing/test_path.h"
#include "slam/evaluation/trajectory_io.h"

namespace corbslam::services {
namespace {

using ::testing::StartsWith;

TEST(EurocFileTest, IsReadBackAsItWas) {
  Trajectory written;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, i).normalized();
    written.push_back({1403636579763555584 + i * int64_t{50'000'000},
                       {Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * i - 3, axis)),
                        Eigen::Vector3d(0.1 * i, -5, 1e3)}});
  }
  const std::string path = TestPath("poses.csv");
  ASSERT_TRUE(WriteEurocTrajectory(written, path).ok());
  const auto read = ReadEurocTrajectory(path, Rigid3d());
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), written.size());
  for (size_t i = 0; i < written.size(); ++i) {
    EXPECT_EQ((*read)[i].timestamp_ns, written[i].timestamp_ns);
    EXPECT_LT(((*read)[i].world_from_camera.translation - written[i].world_from_camera.translation)
                  .norm(),
              1e-8);
    EXPECT_LT((*read)[i].world_from_camera.rotation.angularDistance(
                  written[i].world_from_camera.rotation),
              1e-7);
  }
}

TEST(EurocFileTest, HasNanosecondsAndWFirst) {
  const std::string path = TestPath("poses.csv");
  ASSERT_TRUE(
      WriteEurocTrajectory({{12, {Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d(4, 5, 6)}}}, path)
          .ok());
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  EXPECT_THAT(line, StartsWith("#timestamp [ns],p_RS_R_x [m],"));
  std::getline(file, line);
  EXPECT_THAT(line, StartsWith("12,4.000000000,5.000000000,6.000000000,0.000000000,1.000000000,"));
}

TEST(EurocFileTest, SaysWhatItCantWrite) {
  EXPECT_EQ(WriteEurocTrajectory({}, "/nowhere/a.csv").code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace corbslam::services
