// Tests that what programs of the formats that are read wrote is read (tests/data/golden).
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <utility>

#include "map_store/archive/mission_archive.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/journal_check.h"
#include "map_store/store/journal_repair.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;

// Poses of frames are kept as floats.
constexpr double kSamePlace_m = 1e-4;

class GoldenTest : public ::testing::Test {
 protected:
  GoldenTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~GoldenTest() override {
    store_.reset();
    fs::remove_all(folder_);
  }

  void OpenStore(std::unique_ptr<Journal> journal) {
    store_ = std::make_unique<MapStore>(testing::DeterministicOptions(), nullptr,
                                        std::move(journal), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
  }
  // The folder is copied: a start may change it.
  void ReadJournal(const fs::path& golden) {
    const fs::path copy = folder_ / golden.filename();
    fs::copy(golden, copy, fs::copy_options::recursive);
    auto journal = RocksJournal::Open({.directory = copy.string()});
    ASSERT_TRUE(journal.ok()) << journal.status();
    OpenStore(*std::move(journal));
  }
  void ReadBackup(const fs::path& golden) {
    std::ifstream file(golden, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    OpenStore(std::make_unique<InMemoryJournal>());
    MissionRestorer restorer = store_->StartRestoring();
    const absl::Status added = restorer.Add(bytes);
    ASSERT_TRUE(added.ok()) << added;
    absl::StatusOr<MissionState> state = restorer.Finish();
    ASSERT_TRUE(state.ok()) << state.status();
    const absl::Status restored = store_->RestoreMission("golden", *std::move(state));
    ASSERT_TRUE(restored.ok()) << restored;
  }

  // `poses` has where the robot's frames were, as the program said that wrote the data: in TUM's
  // form, in the global frame, of the rectified camera.
  void ExpectPoses(const fs::path& poses) {
    std::ifstream file(poses);
    const auto read = store_->GetTrajectory("golden", "alpha", TrajectoryFrame::kGlobal, false,
                                            PosesOf::kRectifiedCamera);
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(read->size(), 1u);
    size_t frames = 0;
    std::string line;
    while (std::getline(file, line)) {
      if (line.empty() || line.front() == '#') continue;
      std::istringstream fields(line);
      std::string time;
      Eigen::Vector3d place;
      ASSERT_TRUE(fields >> time >> place.x() >> place.y() >> place.z()) << line;
      ASSERT_LT(frames, read->front().poses.size()) << line;
      const StoredPose& pose = read->front().poses[frames++];
      EXPECT_LT((pose.frame_from_camera.translation - place).norm(), kSamePlace_m) << line;
    }
    EXPECT_GT(frames, 0u);
    EXPECT_EQ(frames, read->front().poses.size());
  }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "golden_test";
  std::unique_ptr<MapStore> store_;
};

TEST_F(GoldenTest, WhatWasWrittenIsRead) {
  const fs::path golden = CORBSLAM_GOLDEN_DATA;
  std::ifstream expected(golden / "expected.txt");
  std::string line;
  int read = 0;
  while (std::getline(expected, line)) {
    if (line.empty() || line.front() == '#') continue;
    SCOPED_TRACE(line);
    std::istringstream fields(line);
    std::string name;
    size_t keyframes = 0;
    size_t points = 0;
    ASSERT_TRUE(fields >> name >> keyframes >> points);
    store_.reset();
    if (fs::is_directory(golden / name)) {
      ReadJournal(golden / name);
    } else {
      ReadBackup(golden / name);
    }
    ASSERT_FALSE(HasFatalFailure());
    const auto info = store_->GetMission("golden");
    ASSERT_TRUE(info.ok()) << info.status();
    EXPECT_EQ(info->damage, "");
    EXPECT_EQ(info->keyframes, keyframes);
    EXPECT_EQ(info->map_points, points);
    ExpectPoses(golden / (name + ".poses"));
    ++read;
  }
  EXPECT_GE(read, 4);
}

TEST_F(GoldenTest, AnUpgradeLeavesWhatCheckAndRepairRead) {
  const fs::path golden = CORBSLAM_GOLDEN_DATA;
  std::ifstream expected(golden / "expected.txt");
  std::string line;
  int upgraded = 0;
  while (std::getline(expected, line)) {
    std::istringstream fields(line);
    std::string name;
    size_t keyframes = 0;
    if (!(fields >> name >> keyframes) || !fs::is_directory(golden / name)) continue;
    SCOPED_TRACE(line);
    const fs::path copy = folder_ / (name + "_upgraded");
    fs::copy(golden / name, copy, fs::copy_options::recursive);
    ASSERT_TRUE(RocksJournal::Open({.directory = copy.string()}).ok());
    const auto expect_sound = [&](const CheckedMission& mission) {
      EXPECT_TRUE(mission.status.ok()) << mission.status;
      EXPECT_EQ(mission.keyframes, keyframes);
    };
    ASSERT_TRUE(map_store::CheckJournal(copy, expect_sound).ok());
    const auto repaired = map_store::RepairMission(copy, "golden", folder_ / (name + ".repaired"));
    ASSERT_TRUE(repaired.ok()) << repaired.status();
    EXPECT_EQ(repaired->keyframes, keyframes);
    EXPECT_EQ(repaired->left_out, 0u);
    ++upgraded;
  }
  EXPECT_GE(upgraded, 2);
}

}  // namespace
}  // namespace corbslam::map_store
