// Tests that what people limit of a mission holds for robots that only localise, too.
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "map_store/testing/sleeping_store.h"

namespace corbslam::map_store {
namespace {

class LocalisedLimitsTest : public testing::SleepingStore {
 protected:
  LocalisedLimitsTest() {
    Fill(kMission, map_a_);
    SessionRequest request;
    request.mission = kMission;
    request.agent = "guest";
    request.localise_only = true;
    session_ = store_->OpenSession(request)->session_id;
  }
  // Each part has a hundred frames; or a lost one alone.
  std::optional<uint64_t> Send(uint64_t number, bool is_lost = false) {
    LocalisedFrames part;
    part.run = 7;
    part.number = number;
    const auto begin_ns = static_cast<int64_t>(1000 * number);
    for (uint32_t i = 0; !is_lost && i < 100; ++i) {
      part.tracked_frames.push_back({begin_ns + i, {{0xa}, 0}, Rigid3d::Identity()});
    }
    if (is_lost) part.lost_frames_ns = {begin_ns};
    const auto kept = store_->NoteLocalised(session_, part);
    EXPECT_TRUE(kept.ok()) << kept.status();
    if (!kept.ok() || !kept->has_value()) return std::nullopt;
    return (*kept)->number;
  }
  uint64_t MemoryBytes() const { return store_->GetMission(kMission)->memory_bytes; }
  void LimitMemory(uint64_t bytes) {
    MissionProfile values;
    values.limits.memory_bytes = bytes;
    ASSERT_TRUE(store_->UpdateMission(kMission, values, {ProfileField::kLimits}).ok());
  }

  uint64_t session_ = 0;
};

TEST_F(LocalisedLimitsTest, TheTrajectoryIsOfTheMissionsMemory) {
  const uint64_t before = MemoryBytes();
  EXPECT_EQ(Send(1), 1u);
  EXPECT_GE(MemoryBytes(), before + 100 * sizeof(TrackedFrame));
  EXPECT_LE(MemoryBytes(), before + 150 * sizeof(TrackedFrame));
}

TEST_F(LocalisedLimitsTest, OverTheMissionsMemoryNothingIsKeptUntilThereIsRoom) {
  EXPECT_EQ(Send(1), 1u);
  LimitMemory(MemoryBytes() + 50 * sizeof(TrackedFrame));
  EXPECT_EQ(Send(2), std::nullopt);
  EXPECT_EQ(Send(1), 1u) << "what is there is answered";
  EXPECT_EQ(Send(2, /*is_lost=*/true), 2u) << "that it is lost takes no room";
  EXPECT_EQ(Send(3), std::nullopt);
  LimitMemory(0);
  EXPECT_EQ(Send(3), 3u);
}

}  // namespace
}  // namespace corbslam::map_store
