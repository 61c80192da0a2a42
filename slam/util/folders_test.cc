#include "slam/util/folders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace corbslam {
namespace {

using ::testing::HasSubstr;

TEST(FoldersTest, AreMadeWithThoseAbove) {
  const std::string top = ::testing::TempDir() + "corbslam_folders_test_made";
  std::filesystem::remove_all(top);
  EXPECT_EQ(NearestThere(top + "/a/b"), std::filesystem::path(top).parent_path());
  EXPECT_TRUE(MakeFolder(top + "/a/b").ok());
  EXPECT_TRUE(MakeFolder(top + "/a/b").ok());
  EXPECT_EQ(NearestThere(top + "/a/c/d"), top + "/a");
  std::filesystem::remove_all(top);
}

TEST(FoldersTest, AreNewWhereNothingIsIn) {
  const std::string top = ::testing::TempDir() + "corbslam_folders_test_new";
  std::filesystem::remove_all(top);
  EXPECT_TRUE(CheckNewFolder(top).ok());
  EXPECT_TRUE(MakeFolder(top).ok());
  EXPECT_TRUE(CheckNewFolder(top).ok());
  std::ofstream(top + "/000000.png") << "x";
  EXPECT_EQ(CheckNewFolder(top).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(CheckNewFolder(top).message(), HasSubstr(top));
  EXPECT_EQ(CheckNewFolder(top + "/000000.png").code(), absl::StatusCode::kFailedPrecondition);
  std::filesystem::remove_all(top);
}

TEST(FoldersTest, ThatCantBeMadeAreNamed) {
  const std::string file = ::testing::TempDir() + "corbslam_folders_test_file";
  std::ofstream(file) << "x";
  const absl::Status status = MakeFolder(file + "/below");
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(status.message(), HasSubstr(file + "/below"));
  EXPECT_EQ(NearestThere(file + "/below"), file);
}

}  // namespace
}  // namespace corbslam
