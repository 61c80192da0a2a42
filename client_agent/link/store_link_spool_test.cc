// Tests the link with a spool on a bad network, over restarts of the robot and of the map store.
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/fake_uplink.h"
#include "client_agent/link/testing/test_payload.h"
#include "client_agent/spool/testing/fake_spool.h"
#include "client_agent/upload/held_back_items.h"
#include "client_agent/upload/spooled_map_reading.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kNext{2};

class StoreLinkSpoolTest : public ::testing::Test {
 protected:
  void StartRobot(LocalMapId local_map, size_t max_outbox_bytes = 0) {
    manager_.reset();
    options_.mission = "m";
    options_.agent = "alpha";
    options_.hold_newest_keyframes = hold_newest_;
    options_.max_outbox_bytes = max_outbox_bytes;
    if (!in_real_time_) options_.clock = [this] { return now_; };
    manager_ = std::make_unique<StoreLink>(
        options_, &uplink_, [](const auto&) { return std::make_shared<Words>(); },
        *OpenFakeSpool(&disk_));
    Begin(local_map);
  }
  void Begin(LocalMapId id) {
    map_ = maps_.emplace_back(std::make_unique<GuardedMap>(id)).get();
    manager_->BeginLocalMap(*map_, jobs_);
  }
  // Moves the keyframe to x = 20, in more steps than batches are made while none waits.
  void MoveForAWhile(KeyframeId id) {
    for (int i = 1; i <= 20; ++i) {
      map_->Write([&](Map& map) {
        map.SetPose(id, {Eigen::Quaterniond::Identity(), {double(i), 0, 0}});
      });
      absl::SleepFor(3 * options_.flush_interval);
    }
  }
  void AddKeyframe(KeyframeId id) {
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(id, 0, 0, std::make_shared<Camera>(), {});
    map_->Write([&](Map& map) { map.AddKeyframe(keyframe); });
  }
  // Steps the link after so much time that any back-off is over.
  void Step() {
    now_ += absl::Minutes(1);
    manager_->Step();
  }
  std::multiset<KeyframeId> StoredKeyframes() const {
    std::multiset<KeyframeId> ids;
    for (const auto& [local_map, batches] : uplink_.stored) {
      for (const MapUpdateBatch& batch : batches) {
        for (const auto& keyframe : batch.full_keyframes) ids.insert(keyframe.payload->id);
      }
    }
    return ids;
  }

  FakeDisk disk_;
  FakeUplink uplink_;
  StoreLinkOptions options_;
  size_t hold_newest_ = 0;
  bool in_real_time_ = false;
  absl::Time now_ = absl::UnixEpoch() + absl::Hours(1);
  FakeMapJobs jobs_;
  std::vector<std::unique_ptr<GuardedMap>> maps_;
  GuardedMap* map_ = nullptr;
  std::unique_ptr<StoreLink> manager_;
};

TEST_F(StoreLinkSpoolTest, ARestartedRobotDrainsItsSpoolAndOpensANewLocalMap) {
  uplink_.reachable = false;
  StartRobot(kOwn);
  for (uint32_t k = 0; k < 20; ++k) {
    AddKeyframe({kOwn, k});
    Step();
  }
  StartRobot(kNext);
  AddKeyframe({kNext, 0});
  uplink_.reachable = true;
  Step();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  const std::multiset<KeyframeId> stored = StoredKeyframes();
  EXPECT_EQ(stored.size(), 21u);
  for (uint32_t k = 0; k < 20; ++k) EXPECT_EQ(stored.count({kOwn, k}), 1u) << k;
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
  Step();
  EXPECT_TRUE(disk_.files.empty());
}

TEST_F(StoreLinkSpoolTest, WhatIsHeldBackIsInTheSpoolWhenARobotEnds) {
  uplink_.reachable = false;
  hold_newest_ = 3;
  StartRobot(kOwn, /*max_outbox_bytes=*/1 << 20);
  for (uint32_t k = 0; k < 5; ++k) AddKeyframe({kOwn, k});
  Step();
  // This frame is tracked after the last batch was made.
  manager_->AddTrackedFrame({1, {kOwn, 4}, {}});
  StartRobot(kNext);
  uplink_.reachable = true;
  Step();
  const std::multiset<KeyframeId> stored = StoredKeyframes();
  for (uint32_t k = 0; k < 5; ++k) EXPECT_EQ(stored.count({kOwn, k}), 1u) << k;
}

TEST_F(StoreLinkSpoolTest, ARobotThatEndsUnreachedLeavesEverythingInItsSpool) {
  uplink_.reachable = false;
  StartRobot(kOwn, /*max_outbox_bytes=*/1 << 20);
  AddKeyframe({kOwn, 0});
  EXPECT_TRUE(absl::IsDeadlineExceeded(manager_->Finish(absl::ZeroDuration())));
  EXPECT_TRUE(disk_.files.empty()) << "memory had room";
  uplink_.reachable = true;
  StartRobot(kNext);
  Step();
  EXPECT_EQ(StoredKeyframes().count({kOwn, 0}), 1u);
}

// The link has its thread here: only the thread waits with batches while there is no session.
TEST_F(StoreLinkSpoolTest, LightUpdatesCoalesceWhileBatchesWait) {
  uplink_.reachable = false;
  in_real_time_ = true;
  options_.min_backoff = options_.max_backoff = absl::Milliseconds(1);
  options_.flush_interval = absl::Milliseconds(1);
  StartRobot(kOwn, 1 << 20);
  AddKeyframe({kOwn, 0});
  Step();  // The first batch waits.
  manager_->Start();
  MoveForAWhile({kOwn, 0});
  EXPECT_EQ(manager_->upload().batches, 1u) << "none was made for a light update";
  uplink_.reachable = true;
  EXPECT_TRUE(manager_->Finish(absl::Seconds(10)).ok());
  std::vector<LightKeyframe> light;
  for (const MapUpdateBatch& batch : uplink_.stored[kOwn]) {
    light.insert(light.end(), batch.light_keyframes.begin(), batch.light_keyframes.end());
  }
  ASSERT_EQ(light.size(), 1u);
  EXPECT_EQ(light[0].camera_from_local.translation.x(), 20);
  EXPECT_EQ(StoredKeyframes().size(), 1u);
}

TEST_F(StoreLinkSpoolTest, LightUpdatesCoalesceAfterALocalMapWasClosed) {
  in_real_time_ = true;
  options_.min_backoff = options_.max_backoff = absl::Milliseconds(1);
  options_.flush_interval = absl::Milliseconds(1);
  StartRobot(kOwn, 1 << 20);
  AddKeyframe({kOwn, 0});
  Step();
  Begin(kNext);
  AddKeyframe({kNext, 0});
  Step();
  ASSERT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
  uplink_.reachable = false;
  uplink_.Break(absl::UnavailableError("cut"));
  AddKeyframe({kNext, 1});
  Step();  // This batch waits.
  manager_->Start();
  MoveForAWhile({kNext, 0});
  EXPECT_EQ(manager_->upload().batches, 1u) << "none was made for a light update";
}

TEST_F(StoreLinkSpoolTest, WhoFinishesHasEverythingInTheSpoolWhileItWaits) {
  uplink_.reachable = false;
  in_real_time_ = true;
  StartRobot(kOwn, /*max_outbox_bytes=*/1 << 20);
  AddKeyframe({kOwn, 0});
  manager_->Start();
  EXPECT_TRUE(absl::IsDeadlineExceeded(manager_->Finish(absl::Seconds(1))));
  EXPECT_EQ(manager_->upload().memory_bytes, 0u);
  EXPECT_FALSE(disk_.files.empty());
}

TEST_F(StoreLinkSpoolTest, AStoreThatForgotEverythingIsSaidAndANewLocalMapWorks) {
  StartRobot(kOwn, 1 << 20);
  AddKeyframe({kOwn, 0});
  Step();
  EXPECT_FALSE(manager_->NeedsNewLocalMap());
  // The store comes back empty.
  uplink_.stored[kOwn].clear();
  uplink_.Break(absl::UnavailableError("restarted"));
  AddKeyframe({kOwn, 1});
  Step();
  EXPECT_TRUE(manager_->NeedsNewLocalMap());
  EXPECT_TRUE(absl::IsDataLoss(manager_->upload().loss)) << manager_->upload().loss;
  Begin(kNext);
  EXPECT_FALSE(manager_->NeedsNewLocalMap());
  AddKeyframe({kNext, 0});
  Step();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(StoredKeyframes(), (std::multiset<KeyframeId>{{kNext, 0}}));
}

// The local map in use is asked about even when nothing of it waits.
TEST_F(StoreLinkSpoolTest, ALossIsNoticedAsSoonAsTheStoreIsBack) {
  StartRobot(kOwn, 1 << 20);
  AddKeyframe({kOwn, 0});
  Step();
  uplink_.stored[kOwn].clear();
  uplink_.Break(absl::UnavailableError("restarted"));
  Step();
  EXPECT_TRUE(manager_->NeedsNewLocalMap());
}

TEST_F(StoreLinkSpoolTest, FinishSaysThatTheLocalMapCouldNotGoOn) {
  StartRobot(kOwn, 1 << 20);
  AddKeyframe({kOwn, 0});
  Step();
  uplink_.stored[kOwn].clear();
  uplink_.Break(absl::UnavailableError("restarted"));
  Step();
  EXPECT_TRUE(absl::IsDataLoss(manager_->Finish(absl::Seconds(1))));
}

TEST_F(StoreLinkSpoolTest, AnIdThatIsInTheSpoolIsNotUsedAgain) {
  uplink_.reachable = false;
  StartRobot(kOwn);
  AddKeyframe({kOwn, 0});
  Step();
  StartRobot(kOwn);
  EXPECT_TRUE(manager_->NeedsNewLocalMap());
  AddKeyframe({kOwn, 7});
  Begin(kNext);
  EXPECT_FALSE(manager_->NeedsNewLocalMap());
  AddKeyframe({kNext, 0});
  uplink_.reachable = true;
  Step();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(StoredKeyframes(), (std::multiset<KeyframeId>{{kOwn, 0}, {kNext, 0}}));
}

TEST_F(StoreLinkSpoolTest, ADurableStoreThatWasRestartedIsResumedFrom) {
  StartRobot(kOwn, 1 << 20);
  AddKeyframe({kOwn, 0});
  Step();
  uplink_.acknowledge = false;
  AddKeyframe({kOwn, 1});
  Step();
  uplink_.Break(absl::UnavailableError("killed"));
  uplink_.acknowledge = true;
  AddKeyframe({kOwn, 2});
  Step();
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(StoredKeyframes(), (std::multiset<KeyframeId>{{kOwn, 0}, {kOwn, 1}, {kOwn, 2}}));
  EXPECT_TRUE(manager_->upload().loss.ok());
}

TEST_F(StoreLinkSpoolTest, BacksOffFromAStoreThatOpensSessionsAndEndsThem) {
  options_.min_backoff = absl::Milliseconds(100);
  options_.max_backoff = absl::Seconds(10);
  StartRobot(kOwn, 1 << 20);
  manager_->Step();
  ASSERT_EQ(uplink_.requests.size(), 1u);
  // For a minute the link is tried every 10 ms.
  for (int i = 0; i < 6000; ++i) {
    if (uplink_.open) uplink_.Break(absl::ResourceExhaustedError("too many streams"));
    now_ += absl::Milliseconds(10);
    manager_->Step();
  }
  EXPECT_GT(uplink_.requests.size(), 8u);
  EXPECT_LT(uplink_.requests.size(), 25u);
}

TEST_F(StoreLinkSpoolTest, AFullDiskStopsTheUploadOnlyAndNothingIsLost) {
  uplink_.reachable = false;
  disk_.capacity = 3000;
  StartRobot(kOwn);
  for (uint32_t k = 0; k < 300; ++k) {
    AddKeyframe({kOwn, k});
    manager_->Step();
  }
  EXPECT_TRUE(absl::IsResourceExhausted(manager_->upload().room)) << manager_->upload().room;
  EXPECT_LE(manager_->upload().batches, 20u);
  uplink_.reachable = true;
  while (StoredKeyframes().size() < 300) {
    const size_t before = StoredKeyframes().size();
    Step();
    ASSERT_GT(StoredKeyframes().size(), before);
  }
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(StoredKeyframes().size(), 300u);
  EXPECT_TRUE(manager_->upload().room.ok()) << manager_->upload().room;
}

// All that is mapped is to outlive the process, held back or not, sent or not.
class DurableLinkTest : public StoreLinkSpoolTest {
 protected:
  void Start(Uplink* uplink, bool resumable = false, bool goes_on = false) {
    manager_.reset();
    options_.mission = "m";
    options_.agent = "alpha";
    options_.spool_within = absl::Seconds(1);
    options_.resumable = resumable;
    options_.clock = [this] { return now_; };
    auto spool = *OpenFakeSpool(&disk_);
    ASSERT_TRUE(TellHeldBack(*spool).ok());
    if (goes_on) spooled_map_.emplace(*ReadNewestSpooledMap(*spool));
    manager_ = std::make_unique<StoreLink>(
        options_, uplink, [](const auto&) { return std::make_shared<Words>(); }, std::move(spool),
        goes_on ? spooled_map_->local_map() : LocalMapId());
    if (!goes_on) return Begin(kOwn);
    map_ = maps_.emplace_back(std::make_unique<GuardedMap>(spooled_map_->local_map())).get();
    map_->Write([&](Map& map) {
      spooled_map_->Fill([](const auto&) { return std::make_shared<const Words>(); }, map);
    });
    manager_->BeginLocalMap(*map_, jobs_, &*spooled_map_);
  }
  void AddMapped(uint32_t index) {
    Keyframe keyframe;
    keyframe.payload = testing::MakeTestPayload({kOwn, index}, 3);
    if (index > 0) keyframe.parent = {kOwn, index - 1};
    map_->Write([&](Map& map) { map.AddKeyframe(keyframe); });
    now_ += absl::Seconds(1);
    manager_->Step();
  }
  // The process ends as by a SIGKILL, after the steps that it made.
  void Kill() {
    const FakeDisk left = disk_;
    const auto stored = uplink_.stored;
    manager_.reset();
    disk_ = left;
    uplink_.stored = stored;
    uplink_.open = false;
  }
  std::set<KeyframeId> Expected(uint32_t keyframes) const {
    std::set<KeyframeId> ids;
    for (uint32_t i = 0; i < keyframes; ++i) ids.insert({kOwn, i});
    return ids;
  }
  std::set<KeyframeId> Stored() const {
    const std::multiset<KeyframeId> stored = StoredKeyframes();
    return {stored.begin(), stored.end()};
  }

  std::optional<SpooledMap> spooled_map_;
};

TEST_F(DurableLinkTest, AKilledRobotLosesNothingWithoutALink) {
  options_.hold_newest_keyframes = 7;
  Start(nullptr);
  for (uint32_t i = 0; i < 12; ++i) AddMapped(i);
  Kill();
  Start(&uplink_);
  Begin(kNext);
  Step();
  Step();
  EXPECT_EQ(Stored(), Expected(12));
  EXPECT_EQ(StoredKeyframes().size(), 12u) << "each once";
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
}

TEST_F(DurableLinkTest, WithALinkWhatIsHeldBackIsNotLostEither) {
  options_.hold_newest_keyframes = 7;
  Start(&uplink_);
  for (uint32_t i = 0; i < 12; ++i) AddMapped(i);
  EXPECT_LT(Stored().size(), 12u) << "the newest are held back";
  Kill();
  Start(&uplink_);
  Begin(kNext);
  Step();
  EXPECT_EQ(Stored(), Expected(12));
  EXPECT_EQ(StoredKeyframes().size(), 12u);
}

TEST_F(DurableLinkTest, WithoutALinkTheEndWaitsForTheDiskAlone) {
  Start(nullptr);
  AddMapped(0);
  EXPECT_TRUE(manager_->Finish(absl::Seconds(10)).ok());
  EXPECT_EQ(manager_->upload().memory_bytes, 0u);
  EXPECT_GT(disk_.syncs, 0);
}

TEST_F(DurableLinkTest, WithoutALinkADiskThatIsFullIsSaidAtTheEnd) {
  Start(nullptr);
  disk_.capacity = 1;
  AddMapped(0);
  EXPECT_TRUE(absl::IsResourceExhausted(manager_->Finish(absl::Seconds(10))));
}

TEST_F(DurableLinkTest, AKilledRobotGoesOnWithItsLocalMap) {
  options_.hold_newest_keyframes = 7;
  Start(&uplink_, /*resumable=*/true);
  for (uint32_t i = 0; i < 12; ++i) AddMapped(i);
  Kill();
  Start(&uplink_, /*resumable=*/true, /*goes_on=*/true);
  EXPECT_EQ(map_->own_items().keyframes, 12);
  for (uint32_t i = 12; i < 15; ++i) AddMapped(i);
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(Stored(), Expected(15));
  EXPECT_EQ(StoredKeyframes().size(), 15u) << "each once, in one local map";
  ASSERT_EQ(uplink_.stored.size(), 1u);
  for (const MapUpdateBatch& batch : uplink_.stored[kOwn]) EXPECT_FALSE(batch.closes_local_map);
  EXPECT_EQ(manager_->upload().lost_local_maps, 0);
}

TEST_F(DurableLinkTest, WhatDoesNotGoOnIsClosed) {
  Start(&uplink_, /*resumable=*/true);
  for (uint32_t i = 0; i < 3; ++i) AddMapped(i);
  Kill();
  Start(&uplink_, /*resumable=*/true, /*goes_on=*/true);
  Begin(kNext);
  Step();
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
  EXPECT_EQ(Stored(), Expected(3));
}

}  // namespace
}  // namespace corbslam::client_agent
