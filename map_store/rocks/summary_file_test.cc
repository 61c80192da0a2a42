#include "map_store/rocks/summary_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;

class SummaryFileTest : public ::testing::Test {
 protected:
  SummaryFileTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    Write("CURRENT", "MANIFEST-000004\n");
  }
  ~SummaryFileTest() override { fs::remove_all(folder_); }

  void Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  absl::Status Read() const { return ReadSummaryFile(folder_.string()).status(); }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "summary_file_test" /
                           ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(SummaryFileTest, IsReadAndReplacedAndGoes) {
  const std::string folder = folder_.string();
  EXPECT_TRUE(absl::IsNotFound(Read()));
  const std::string bytes("a\0b", 3);
  ASSERT_TRUE(WriteSummaryFile(folder, bytes).ok());
  EXPECT_EQ(*ReadSummaryFile(folder), bytes);
  ASSERT_TRUE(WriteSummaryFile(folder, "").ok());
  EXPECT_EQ(*ReadSummaryFile(folder), "");
  RemoveSummaryFile(folder);
  EXPECT_TRUE(absl::IsNotFound(Read()));
  RemoveSummaryFile(folder);
}

TEST_F(SummaryFileTest, IsNotBelievedOnceTheDatabaseWasOpened) {
  ASSERT_TRUE(WriteSummaryFile(folder_.string(), "summary").ok());
  Write("CURRENT", "MANIFEST-000009\n");
  EXPECT_TRUE(absl::IsDataLoss(Read())) << Read();
  fs::remove(folder_ / "CURRENT");
  EXPECT_FALSE(Read().ok());
  EXPECT_FALSE(WriteSummaryFile(folder_.string(), "summary").ok()) << "there is no database";
}

TEST_F(SummaryFileTest, EveryTurnedBitAndEveryCutIsFound) {
  ASSERT_TRUE(WriteSummaryFile(folder_.string(), "summary").ok());
  std::string whole;
  {
    std::ifstream file(folder_ / kSummaryFile, std::ios::binary);
    whole.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    Write(kSummaryFile, damaged);
    EXPECT_TRUE(absl::IsDataLoss(Read())) << "byte " << i;
    Write(kSummaryFile, whole.substr(0, i));
    EXPECT_TRUE(absl::IsDataLoss(Read())) << "cut at " << i;
  }
  Write(kSummaryFile, whole + whole);
  EXPECT_TRUE(absl::IsDataLoss(Read()));
  Write(kSummaryFile, std::string(2 << 20, 'x'));
  EXPECT_TRUE(absl::IsDataLoss(Read()));
}

}  // namespace
}  // namespace corbslam::map_store
