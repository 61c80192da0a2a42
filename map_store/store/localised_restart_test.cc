// Tests that the trajectory of a robot that only localises outlives the store's process.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/archive/mission_archive.h"
#include "map_store/testing/sleeping_store.h"

namespace corbslam::map_store {
namespace {

constexpr uint64_t kRun = 0xabc;

class LocalisedRestartTest : public testing::SleepingStore {
 protected:
  LocalisedRestartTest() { Fill(kMission, map_a_); }

  uint64_t OpenGuest() {
    SessionRequest request;
    request.mission = kMission;
    request.agent = "guest";
    request.localise_only = true;
    const auto opened = store_->OpenSession(request);
    EXPECT_TRUE(opened.ok()) << opened.status();
    EXPECT_TRUE(opened->grant.capabilities.keeps_localised);
    return opened->session_id;
  }
  // Each part has two frames and then a lost one.
  static LocalisedFrames Part(uint64_t number) {
    LocalisedFrames part;
    part.run = kRun;
    part.number = number;
    const auto begin_ns = static_cast<int64_t>(100 * number);
    for (uint32_t i = 0; i < 2; ++i) {
      part.tracked_frames.push_back(
          {begin_ns + i, {{0xa}, i}, {Eigen::Quaterniond::Identity(), {0.25, 0, 0}}});
    }
    part.lost_frames_ns = {begin_ns + 50};
    return part;
  }
  // Returns the last part that is kept; nullopt: the store does not say.
  std::optional<uint64_t> Send(uint64_t session, uint64_t number) {
    const auto kept = store_->NoteLocalised(session, Part(number));
    EXPECT_TRUE(kept.ok()) << kept.status();
    if (!kept.ok() || !kept->has_value()) return std::nullopt;
    EXPECT_EQ((*kept)->run, kRun);
    return (*kept)->number;
  }
  std::vector<StoredPose> Poses(const std::string& mission = kMission) {
    const auto read = store_->GetTrajectory(mission, "guest", TrajectoryFrame::kGlobal);
    EXPECT_TRUE(read.ok()) << read.status();
    if (!read.ok()) return {};
    dropped_ = read->front().dropped;
    return read->front().poses;
  }
  static std::string Times(const std::vector<StoredPose>& poses) {
    std::string text;
    for (const StoredPose& pose : poses) {
      absl::StrAppend(&text, pose.after_gap ? "| " : "", pose.timestamp_ns, " ");
    }
    return text;
  }

  uint64_t dropped_ = 0;
};

TEST_F(LocalisedRestartTest, WhatWasAnsweredIsThereAfterwardsOnce) {
  uint64_t session = OpenGuest();
  EXPECT_EQ(Send(session, 1), 1u);
  EXPECT_EQ(Send(session, 1), 1u) << "the answer was lost, and it came again";
  EXPECT_EQ(Send(session, 3), 1u) << "it leaves a gap";
  EXPECT_EQ(Send(session, 2), 2u);
  const std::vector<StoredPose> before = Poses();
  EXPECT_EQ(Times(before), "100 101 | 200 201 ");
  Open();
  const std::vector<StoredPose> after = Poses();
  EXPECT_EQ(Times(after), Times(before));
  for (size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].frame_from_camera.translation, before[i].frame_from_camera.translation);
  }
  session = OpenGuest();
  EXPECT_EQ(Send(session, 2), 2u);
  EXPECT_EQ(Send(session, 3), 3u);
  EXPECT_EQ(Times(Poses()), "100 101 | 200 201 | 300 301 ");
}

TEST_F(LocalisedRestartTest, ASnapshotAndABackupHaveIt) {
  const uint64_t session = OpenGuest();
  EXPECT_EQ(Send(session, 1), 1u);
  store_->CloseSession(session);
  ASSERT_TRUE(store_->SleepMission(kMission).ok());
  EXPECT_GT(counts_.snapshots, 0);
  EXPECT_EQ(Times(Poses()), "100 101 ");
  Open();
  EXPECT_EQ(Times(Poses()), "100 101 ");
  MissionBackup backup = *store_->BackUpMission(kMission);
  MissionRestorer restorer = store_->StartRestoring();
  for (std::string piece = backup.Next(1 << 20); !piece.empty(); piece = backup.Next(1 << 20)) {
    ASSERT_TRUE(restorer.Add(piece).ok());
  }
  ASSERT_TRUE(store_->RestoreMission("copy", *restorer.Finish()).ok());
  EXPECT_EQ(Times(Poses("copy")), "100 101 ");
  EXPECT_EQ(Send(OpenGuest(), 1), 1u) << "it is known after all that";
}

TEST_F(LocalisedRestartTest, ALongTrajectoryIsCoarserAndThatIsSaid) {
  options_.max_localised_frames_per_agent = 5;
  Open();
  const uint64_t session = OpenGuest();
  for (uint64_t number = 1; number <= 3; ++number) EXPECT_EQ(Send(session, number), number);
  EXPECT_EQ(Times(Poses()), "100 | 200 | 300 ");
  EXPECT_EQ(dropped_, 3u);
  Open();
  EXPECT_EQ(Times(Poses()), "100 | 200 | 300 ");
  EXPECT_EQ(dropped_, 3u);
}

TEST_F(LocalisedRestartTest, WhatMeansNothingIsRefusedAndNotKept) {
  LocalisedFrames part = Part(1);
  part.tracked_frames[1].reference_from_camera.translation.x() = NAN;
  const uint64_t session = OpenGuest();
  const auto refused = store_->NoteLocalised(session, part);
  EXPECT_TRUE(absl::IsInvalidArgument(refused.status())) << refused.status();
  EXPECT_EQ(Send(session, 1), 1u);
}

// A journal that refuses, as on a full disk, while it is told to.
class RefusingJournal : public testing::JournalWrapper {
 public:
  RefusingJournal(std::unique_ptr<Journal> journal, bool* refuses)
      : JournalWrapper(std::move(journal)), refuses_(*refuses) {}
  absl::StatusOr<Position> Append(absl::string_view mission, const JournalRecord& record) override {
    if (refuses_) return absl::ResourceExhaustedError("no room");
    return JournalWrapper::Append(mission, record);
  }

 private:
  bool& refuses_;
};

TEST_F(LocalisedRestartTest, WithoutRoomTheSessionGoesOnAndNothingIsAnswered) {
  bool refuses = false;
  store_ = std::make_unique<MapStore>(
      options_, testing::TheWorld().vocabulary,
      std::make_unique<RefusingJournal>(std::make_unique<InMemoryJournal>(), &refuses), worker_,
      [this] { return now_; });
  Fill(kMission, map_a_);
  const uint64_t session = OpenGuest();
  refuses = true;
  EXPECT_EQ(Send(session, 1), std::nullopt);
  EXPECT_EQ(Send(session, 2), 0u) << "the first is missing";
  EXPECT_TRUE(Poses().empty());
  refuses = false;
  EXPECT_EQ(Send(session, 1), 1u);
  EXPECT_EQ(Send(session, 2), 2u);
}

}  // namespace
}  // namespace corbslam::map_store
