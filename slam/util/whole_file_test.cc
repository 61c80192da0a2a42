#include "slam/util/whole_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace corbslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class WholeFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = ::testing::TempDir() + "/corbslam_whole_file_" +
            ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove(path_);
  }
  void TearDown() override { EXPECT_FALSE(std::filesystem::exists(path_ + ".part")); }

  std::string path_;
};

TEST_F(WholeFileTest, IsThereOnceItIsWhole) {
  auto file = WholeFile::Create(path_);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_TRUE(file->Append("one ").ok());
  ASSERT_TRUE(file->Append("two").ok());
  EXPECT_FALSE(std::filesystem::exists(path_));
  ASSERT_TRUE(file->Finish().ok());
  EXPECT_EQ(Read(path_), "one two");
}

TEST_F(WholeFileTest, KeepsOrReplacesWhatIsThere) {
  std::ofstream(path_) << "old";
  const auto kept = WholeFile::Create(path_);
  EXPECT_EQ(kept.status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(std::string(kept.status().message()), HasSubstr(path_));
  {
    auto given_up = WholeFile::Create(path_, WholeFile::Old::kReplaced);
    ASSERT_TRUE(given_up.ok()) << given_up.status();
    ASSERT_TRUE(given_up->Append("half").ok());
  }
  EXPECT_EQ(Read(path_), "old");
  auto file = WholeFile::Create(path_, WholeFile::Old::kReplaced);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_TRUE(file->Append("new").ok());
  ASSERT_TRUE(file->Finish().ok());
  EXPECT_EQ(Read(path_), "new");
}

TEST_F(WholeFileTest, SaysWhatItCantWrite) {
  const auto file = WholeFile::Create("/nowhere/a");
  EXPECT_EQ(file.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(file.status().message()), HasSubstr("/nowhere/a"));
}

TEST_F(WholeFileTest, WritesWholeOrLeavesWhatWasThere) {
  ASSERT_TRUE(WriteWhole(path_, "old").ok());
  std::filesystem::create_symlink("/dev/full", path_ + ".part");
  const absl::Status full = WriteWhole(path_, "new");
  std::filesystem::remove(path_ + ".part");
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(full.message()), AllOf(HasSubstr(path_), HasSubstr("No space left")));
  EXPECT_EQ(Read(path_), "old");
  using std::filesystem::perms;
  std::filesystem::permissions(path_, perms::owner_read | perms::owner_write);
  ASSERT_TRUE(WriteWhole(path_, "new").ok());
  EXPECT_EQ(Read(path_), "new");
  EXPECT_EQ(std::filesystem::status(path_).permissions(), perms::owner_read | perms::owner_write);
}

TEST_F(WholeFileTest, FollowsLinksAndLeavesDevicesWhereTheyAre) {
  const std::string link = path_ + ".link";
  std::filesystem::remove(link);
  ASSERT_TRUE(WriteWhole(path_, "old").ok());
  std::filesystem::create_symlink(path_, link);
  ASSERT_TRUE(WriteWhole(link, "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(Read(path_), "new");
  std::filesystem::remove(link);
  EXPECT_EQ(WriteWhole("/dev/full", "bytes").code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST_F(WholeFileTest, SaysWhyItCantWrite) {
  const absl::Status nowhere = WriteWhole("/nowhere/a.svg", "");
  EXPECT_EQ(nowhere.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(nowhere.message()), HasSubstr("No such file or directory"));
  const absl::Status folder = WriteWhole(::testing::TempDir(), "");
  EXPECT_EQ(folder.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(folder.message()), HasSubstr("name a file in it"));
}

}  // namespace
}  // namespace corbslam
