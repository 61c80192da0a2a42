// Tests what the store refuses for being too much, and what waits only so long.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/blank_batch.h"

namespace corbslam::map_store {
namespace {

using testing::BlankBatch;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr LocalMapId kMapA{0xa};
constexpr LocalMapId kMapB{0xb};

class LimitsTest : public ::testing::Test {
 protected:
  void Start() {
    options_.deterministic = true;
    store_ = std::make_unique<MapStore>(options_, nullptr, std::make_unique<InMemoryJournal>(),
                                        nullptr, [this] { return now_; });
  }
  uint64_t Open(const std::string& agent, const std::vector<LocalMapId>& local_maps = {}) {
    return *OpenStatus(agent, "m", local_maps);
  }
  absl::StatusOr<uint64_t> OpenStatus(const std::string& agent, const std::string& mission,
                                      const std::vector<LocalMapId>& local_maps = {}) {
    SessionRequest request;
    request.mission = mission;
    request.agent = agent;
    request.local_maps = local_maps;
    const auto opened = store_->OpenSession(request);
    if (!opened.ok()) return opened.status();
    return opened->session_id;
  }

  static void ExpectTooMuch(const absl::Status& status, const std::vector<std::string>& says) {
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    for (const std::string& part : says) {
      EXPECT_THAT(std::string(status.message()), HasSubstr(part));
    }
  }

  MapStoreOptions options_;
  absl::Time now_ = absl::UnixEpoch();
  std::unique_ptr<MapStore> store_;
};

TEST_F(LimitsTest, BytesOfAKeyframe) {
  options_.max_keyframe_bytes = 5000;
  Start();
  const uint64_t a = Open("a");
  ExpectTooMuch(store_->Apply(a, BlankBatch(kMapA, 1, 200)).status(),
                {"000000000000000a:1", "limit is 5000"});
  EXPECT_TRUE(store_->Apply(a, BlankBatch(kMapA, 1, 90)).ok());
}

TEST_F(LimitsTest, BytesOfAnAgentAndNobodyElse) {
  options_.max_bytes_per_agent = 20000;
  Start();
  const uint64_t a = Open("a");
  const uint64_t b = Open("b");
  uint64_t stored = 0;
  absl::Status status;
  for (uint64_t number = 1; status.ok() && number < 100; ++number) {
    status = store_->Apply(a, BlankBatch(kMapA, number, 100)).status();
    stored += status.ok() ? 1 : 0;
  }
  ExpectTooMuch(status, {"agent a has", "limit is 20000", "000000000000000a"});
  EXPECT_GE(stored, 2u);
  EXPECT_LE(stored, 4u);
  // Other local maps of the agent count, too; other agents go on, and so do duplicates.
  ExpectTooMuch(store_->Apply(a, BlankBatch({0xc}, 1, 100)).status(), {"agent a has"});
  EXPECT_TRUE(store_->Apply(b, BlankBatch(kMapB, 1, 100)).ok());
  EXPECT_EQ(store_->Apply(a, BlankBatch(kMapA, 1, 100))->number, stored);
  EXPECT_EQ(store_->GetLocalMap("m", kMapA)->keyframes, stored);
}

TEST_F(LimitsTest, BytesOfAMission) {
  options_.max_bytes_per_mission = 20000;
  Start();
  const uint64_t a = Open("a");
  const uint64_t b = Open("b");
  EXPECT_TRUE(store_->Apply(a, BlankBatch(kMapA, 1, 150)).ok());
  EXPECT_TRUE(store_->Apply(b, BlankBatch(kMapB, 1, 150)).ok());
  ExpectTooMuch(store_->Apply(b, BlankBatch(kMapB, 2, 150)).status(), {"mission m has", "20000"});
  // Another mission has a limit of its own.
  const uint64_t other = *OpenStatus("a", "n");
  EXPECT_TRUE(store_->Apply(other, BlankBatch({0xd}, 1, 150)).ok());
}

TEST_F(LimitsTest, MissionsAgentsAndLocalMaps) {
  options_.max_missions = 1;
  options_.max_agents_per_mission = 2;
  options_.max_local_maps_per_mission = 1;
  Start();
  const uint64_t a = Open("a");
  ExpectTooMuch(OpenStatus("a", "n").status(), {"1 missions"});
  EXPECT_TRUE(OpenStatus("b", "m").ok());
  ExpectTooMuch(OpenStatus("c", "m").status(), {"mission m has 2 agents"});
  EXPECT_TRUE(store_->Apply(a, BlankBatch(kMapA, 1)).ok());
  ExpectTooMuch(store_->Apply(a, BlankBatch(kMapB, 1)).status(),
                {"mission m has 1 local maps", "limit is 1"});
}

TEST_F(LimitsTest, AMissionThatNobodyWroteToIsForgotten) {
  options_.max_missions = 1;
  options_.max_local_maps_per_mission = 1;
  Start();
  const auto names = [this] {
    std::vector<std::string> listed;
    const auto page = store_->ListMissions({});
    for (const MissionInfo& mission : page->items) listed.push_back(mission.name);
    return listed;
  };
  for (int i = 0; i < 3; ++i) {
    const auto session = OpenStatus("a", absl::StrCat("made-up-", i));
    ASSERT_TRUE(session.ok()) << session.status();
    EXPECT_THAT(names(), ElementsAre(absl::StrCat("made-up-", i)));
    store_->CloseSession(*session);
    EXPECT_THAT(names(), IsEmpty());
  }
  // A mission is kept as long as a robot is in it, and also if something was written to it.
  const uint64_t a = Open("a");
  const uint64_t b = Open("b");
  store_->CloseSession(a);
  EXPECT_THAT(names(), ElementsAre("m"));
  ASSERT_TRUE(store_->Apply(b, BlankBatch(kMapB, 1)).ok());
  store_->CloseSession(b);
  EXPECT_THAT(names(), ElementsAre("m"));
  ExpectTooMuch(OpenStatus("a", "other").status(), {"1 missions"});
}

TEST_F(LimitsTest, WhatRefersToNothingWaitsOnlySoLong) {
  options_.max_parked_references = 2;
  options_.max_parked_s = 60;
  Start();
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_->Apply(a, BlankBatch(kMapA, 1, 4)).ok());
  const auto refer = [](uint64_t number, uint32_t keypoint) {
    MapUpdateBatch batch;
    batch.local_map = kMapA;
    batch.number = number;
    batch.observations = {
        {ObservationChange::Kind::kAdded, {kMapA, 90 + keypoint}, {kMapA, 1}, keypoint}};
    return batch;
  };
  ASSERT_TRUE(store_->Apply(a, refer(2, 0)).ok());
  now_ += absl::Seconds(50);
  ASSERT_TRUE(store_->Apply(a, refer(3, 1)).ok());
  EXPECT_EQ(store_->GetLocalMap("m", kMapA)->parked_references, 2u);
  ExpectTooMuch(store_->Apply(a, refer(4, 2)).status(), {"3 references", "limit is 2"});
  // The agent comes back later: the first reference has waited for too long, the second has not.
  now_ += absl::Seconds(20);
  const uint64_t again = Open("a", {kMapA});
  EXPECT_EQ(store_->GetLocalMap("m", kMapA)->parked_references, 1u);
  EXPECT_TRUE(store_->Apply(again, refer(4, 2)).ok());
}

TEST_F(LimitsTest, AParentThatNeverComesWaitsOnce) {
  options_.max_parked_references = 2;
  Start();
  const uint64_t a = Open("a");
  ASSERT_TRUE(store_->Apply(a, BlankBatch(kMapA, 1)).ok());
  for (uint64_t number = 2; number < 20; ++number) {
    MapUpdateBatch batch;
    batch.local_map = kMapA;
    batch.number = number;
    batch.light_keyframes = {{{kMapA, 1}, Rigid3d::Identity(), {kMapA, 77}}};
    ASSERT_TRUE(store_->Apply(a, batch).ok()) << number;
  }
  EXPECT_EQ(store_->GetLocalMap("m", kMapA)->parked_references, 1u);
}

TEST(MapStoreOptionsTest, NoLimitMayBeNothing) {
  const std::vector<std::pair<std::string, std::function<void(MapStoreOptions&)>>> cases = {
      {"max_missions", [](auto& o) { o.max_missions = 0; }},
      {"max_agents_per_mission", [](auto& o) { o.max_agents_per_mission = 0; }},
      {"max_local_maps_per_mission", [](auto& o) { o.max_local_maps_per_mission = 0; }},
      {"max_keypoints_per_keyframe", [](auto& o) { o.max_keypoints_per_keyframe = 0; }},
      {"max_keyframe_bytes", [](auto& o) { o.max_keyframe_bytes = 0; }},
      {"max_cameras_per_local_map", [](auto& o) { o.max_cameras_per_local_map = 0; }},
      {"max_items_per_batch", [](auto& o) { o.max_items_per_batch = 0; }},
      {"max_frames_per_batch", [](auto& o) { o.max_frames_per_batch = 0; }},
      {"max_parked_references", [](auto& o) { o.max_parked_references = 0; }},
      {"max_parked_s", [](auto& o) { o.max_parked_s = -1; }},
      {"max_bytes_per_agent", [](auto& o) { o.max_bytes_per_agent = 0; }},
      {"max_bytes_per_mission", [](auto& o) { o.max_bytes_per_mission = 0; }},
      {"max_backup_bytes", [](auto& o) { o.max_backup_bytes = 0; }}};
  EXPECT_TRUE(MapStoreOptions().Validate().ok());
  for (const auto& [field, break_it] : cases) {
    MapStoreOptions options;
    break_it(options);
    const absl::Status status = options.Validate();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << field;
    EXPECT_THAT(std::string(status.message()), HasSubstr(field));
  }
}

}  // namespace
}  // namespace corbslam::map_store
