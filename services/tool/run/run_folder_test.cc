#include "services/tool/run/run_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::HasSubstr;

class RunFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = TestPath("run");
    fs::remove_all(folder_);
  }
  void Write(const std::string& file, const std::string& text = "old") const {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
  }
  bool Has(const std::string& file) const { return fs::exists(fs::symlink_status(folder_ / file)); }

  fs::path folder_;
};

TEST_F(RunFolderTest, ASecondRunLeavesNothingOfTheFirst) {
  { ASSERT_TRUE(RunFolder::Take(folder_, "corbslam run --robots 3").ok()); }
  for (const char* file :
       {"report.json", "map.png", "alpha.local.tum", "alpha.global+12.tum", "alpha.global+12b.tum",
        "charlie.near.png", "logs/charlie.log", "logs/missions/journal/1", "alone/report.html",
        "alone/logs/bravo.map", "alpha.told.local.tum", "logs/bravo.told.global.tum"}) {
    Write(file);
  }
  for (const char* file : {"notes.txt", "alpha.txt", "zebra.local.tum", "alpha.local+x.tum",
                           "alpha.told.tum", "logs/mine.log", "alone/mine.png"}) {
    Write(file);
  }
  fs::create_symlink("notes.txt", folder_ / "report.md");
  const auto taken = RunFolder::Take(folder_, "corbslam run --robots 2");
  ASSERT_TRUE(taken.ok()) << taken.status();
  for (const char* file :
       {"report.json", "map.png", "alpha.local.tum", "alpha.global+12.tum", "alpha.global+12b.tum",
        "charlie.near.png", "logs/charlie.log", "logs/missions", "alone/report.html",
        "alone/logs/bravo.map", "alpha.told.local.tum", "logs/bravo.told.global.tum"}) {
    EXPECT_FALSE(Has(file)) << file;
  }
  for (const char* file : {"notes.txt", "alpha.txt", "zebra.local.tum", "alpha.local+x.tum",
                           "logs/mine.log", "alone/mine.png", "report.md"}) {
    EXPECT_TRUE(Has(file)) << file;
  }
}

TEST_F(RunFolderTest, WhatNoRunWroteIsNotReplaced) {
  Write("report.md", "my own");
  for (int i = 0; i < 2; ++i) {
    const auto taken = RunFolder::Take(folder_, "corbslam run");
    EXPECT_EQ(taken.status().code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(taken.status().message()),
                AllOf(HasSubstr("report.md"), HasSubstr("name another folder")));
    EXPECT_TRUE(Has("report.md"));
  }
  // A run of an older version left its report, and no note of the command.
  Write("report.json", R"({"mission": "demo", "robots": []})");
  EXPECT_TRUE(RunFolder::Take(folder_, "corbslam run").ok());
  EXPECT_FALSE(Has("report.md"));
}

TEST_F(RunFolderTest, TwoRunsAtOnceNeedTwoFolders) {
  std::optional<absl::StatusOr<RunFolder>> first = RunFolder::Take(folder_, "corbslam run");
  ASSERT_TRUE(first->ok()) << first->status();
  const auto second = RunFolder::Take(folder_, "corbslam run");
  EXPECT_EQ(second.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("another run writes"));
  first.reset();
  EXPECT_TRUE(RunFolder::Take(folder_, "corbslam run").ok());
}

}  // namespace
}  // namespace corbslam::services
