#include "client_agent/source/foreign_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Refusal(const std::string& source) {
  const auto spec = ParseSourceSpec(source);
  if (!spec.ok()) return std::string(spec.status().message());
  const auto reader = OpenReader(*spec);
  return reader.ok() ? "" : std::string(reader.status().message());
}

TEST(ForeignFilesTest, OtherProgramsRecordingsAreCalledByTheirNames) {
  for (const char* source : {"rec.bag", "/data/rec.bag", "rosbag:rec", "rec.db3"}) {
    EXPECT_THAT(Refusal(source), AllOf(HasSubstr("a ROS bag"), HasSubstr("bag:FILE"))) << source;
  }
  EXPECT_THAT(Refusal("mcap:rec.mcap"), HasSubstr("an MCAP recording"));
  EXPECT_THAT(Refusal("drive.mp4"), AllOf(HasSubstr("a film"), HasSubstr("gst:")));
  EXPECT_THAT(Refusal("svo:drive.svo2?frames=0:5"), HasSubstr("a recording of a ZED"));
  for (const char* source : {"drive.oni", "openni2:any", "openni2:drive.oni"}) {
    EXPECT_THAT(Refusal(source), AllOf(HasSubstr("of OpenNI"), HasSubstr("push:SOCKET"))) << source;
  }
}

TEST(ForeignFilesTest, AlsoWhereALayoutIsGiven) {
  const std::string file = ::testing::TempDir() + "/corbslam_foreign_files.bag";
  std::ofstream(file) << "#ROSBAG V2.0\n";
  EXPECT_THAT(Refusal("kitti:" + file), AllOf(HasSubstr(file), HasSubstr("a ROS bag")));
  EXPECT_THAT(Refusal("euroc:" + file), HasSubstr("a ROS bag"));
  std::filesystem::remove(file);
}

TEST(ForeignFilesTest, OthersAreNone) {
  EXPECT_EQ(DescribeForeignFile("kitti_00"), "");
  EXPECT_THAT(Refusal("kitty:folder"), HasSubstr("unknown source layout 'kitty'"));
}

}  // namespace
}  // namespace corbslam::client_agent
