#include "services/security/audit_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

using ::testing::HasSubstr;

std::string LinesIn(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

class AuditFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::testing::TempDir() + "/corbslam_audit_XXXXXX";
    ASSERT_NE(mkdtemp(folder_.data()), nullptr);
    path_ = folder_ + "/audit.log";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string folder_;
  std::string path_;
};

TEST_F(AuditFileTest, GoesOnWhereItEnded) {
  { ASSERT_TRUE((*AuditFile::Open(path_, 1000))->Append("one").ok()); }
  ASSERT_TRUE((*AuditFile::Open(path_, 1000))->Append("two").ok());
  EXPECT_EQ(LinesIn(path_), "one\ntwo\n");
}

TEST_F(AuditFileTest, TakesNoMoreThanTwiceItsBound) {
  const auto file = *AuditFile::Open(path_, 100);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(file->Append("a line of nineteen").ok());
    ASSERT_LE(fs::file_size(path_), 100u);
  }
  EXPECT_EQ(fs::file_size(path_ + ".1"), 95u);
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) files += entry.is_regular_file();
  EXPECT_EQ(files, 2u);
}

TEST_F(AuditFileTest, IsMadeAnewWhereOthersMovedIt) {
  const auto file = *AuditFile::Open(path_, 1000);
  ASSERT_TRUE(file->Append("one").ok());
  fs::rename(path_, path_ + ".old");
  ASSERT_TRUE(file->Append("two").ok());
  EXPECT_EQ(LinesIn(path_), "two\n");
  fs::remove(path_);
  ASSERT_TRUE(file->Append("three").ok());
  EXPECT_EQ(LinesIn(path_), "three\n");
}

TEST_F(AuditFileTest, ADeviceStaysOneHoweverMuchIsWritten) {
  const auto file = *AuditFile::Open("/dev/null", 100);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(file->Append("a line of nineteen").ok());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_FALSE(fs::exists("/dev/null.1"));
}

TEST_F(AuditFileTest, ALinkStaysOneAndWhatItLeadsToIsSetAside) {
  const std::string link = folder_ + "/link.log";
  fs::create_symlink("audit.log", link);
  const auto file = *AuditFile::Open(link, 100);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(file->Append("a line of nineteen").ok());
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(fs::file_size(path_ + ".1"), 95u);
  EXPECT_EQ(LinesIn(link), LinesIn(path_));
}

TEST_F(AuditFileTest, SaysThatTheDiskIsFull) {
  const auto file = AuditFile::Open("/dev/full", 1000);
  ASSERT_TRUE(file.ok()) << file.status();
  const absl::Status full = (*file)->Append("one");
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(full.message()), HasSubstr("can't write /dev/full: No space left"));
}

TEST_F(AuditFileTest, NamesAFolderThatIsNotThere) {
  const absl::Status status = AuditFile::Open(folder_ + "/none/audit.log", 1000).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("--audit-log: can't open"));
}

}  // namespace
}  // namespace corbslam::services
