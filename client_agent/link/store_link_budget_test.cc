// Tests the link with a budget, on a clock of the test's: what goes first, what is held back, and
// that nothing is lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/fake_uplink.h"
#include "client_agent/link/testing/test_payload.h"
#include "client_agent/spool/testing/fake_spool.h"

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kNext{2};
constexpr uint64_t kBytesPerSecond = 10000;
// A keyframe of so many keypoints takes 0.85 s at that rate.
constexpr size_t kKeypoints = 200;

class StoreLinkBudgetTest : public ::testing::Test {
 protected:
  void StartRobot(std::unique_ptr<Spool> spool = nullptr) {
    options_.mission = "m";
    options_.agent = "alpha";
    options_.hold_newest_keyframes = 0;
    options_.uplink_bytes_per_second = kBytesPerSecond;
    options_.downlink_bytes_per_second = 77;
    options_.max_outbox_bytes = spool == nullptr ? 64 << 20 : 0;
    options_.clock = [this] { return now_; };
    manager_ = std::make_unique<StoreLink>(
        options_, &uplink_, [](const auto&) { return std::make_shared<Words>(); },
        std::move(spool));
    Begin(kOwn);
  }
  void Begin(LocalMapId id) {
    auto& map = maps_[id];
    map = std::make_unique<GuardedMap>(id);
    manager_->BeginLocalMap(*map, jobs_);
  }
  void AddKeyframe(KeyframeId id) {
    Keyframe keyframe;
    keyframe.payload = testing::MakeTestPayload(id, kKeypoints);
    maps_[id.local_map]->Write([&](Map& map) { map.AddKeyframe(keyframe); });
  }
  void AddPoint(MapPointId id, KeyframeId reference) {
    MapPoint point;
    point.id = id;
    point.reference = reference;
    point.position_in_map = {0, 0, 10};
    maps_[id.local_map]->Write([&](Map& map) {
      map.AddPoint(point);
      map.AddObservation(id, reference, id.index % kKeypoints);
    });
  }
  // Adds ten keyframes, of which each is the reference of twenty points.
  void AddMap(LocalMapId id) {
    for (uint32_t k = 0; k < 10; ++k) {
      AddKeyframe({id, k});
      for (uint32_t p = 0; p < 20; ++p) AddPoint({id, 20 * k + p}, {id, k});
    }
  }
  // Steps the link as the robot's thread does, for so long.
  void Run(absl::Duration length) {
    for (const absl::Time end = now_ + length; now_ < end; now_ += absl::Milliseconds(100)) {
      manager_->Step();
      // The bound is a little more than what fills in a second, and the last batch.
      const double budget =
          static_cast<double>(kBytesPerSecond) * (1 + absl::ToDoubleSeconds(now_ - start_));
      EXPECT_LE(static_cast<double>(uplink_.bytes), budget + uplink_.wire_factor * 20000);
    }
  }
  std::vector<const MapUpdateBatch*> Batches() const {
    std::vector<const MapUpdateBatch*> batches;
    for (const auto& [local_map, stored] : uplink_.stored) {
      for (const MapUpdateBatch& batch : stored) batches.push_back(&batch);
    }
    return batches;
  }
  UpdateCounts Told() const {
    UpdateCounts told = {};
    for (const MapUpdateBatch* batch : Batches()) {
      const UpdateCounts counts = CountUpdates(*batch);
      for (size_t kind = 0; kind < kUpdateKinds; ++kind) told[kind] += counts[kind];
    }
    return told;
  }
  size_t Told(UpdateKind kind) const { return Told()[static_cast<size_t>(kind)]; }
  void ExpectEachKeyframeOnce(LocalMapId id, size_t count) const {
    std::multiset<KeyframeId> told;
    for (const MapUpdateBatch& batch : uplink_.stored.at(id)) {
      for (const FullKeyframe& keyframe : batch.full_keyframes) told.insert(keyframe.payload->id);
    }
    EXPECT_EQ(told.size(), count);
    EXPECT_EQ(std::set<KeyframeId>(told.begin(), told.end()).size(), count);
  }

  const absl::Time start_ = absl::UnixEpoch() + absl::Hours(1);
  absl::Time now_ = start_;
  FakeDisk disk_;
  FakeUplink uplink_;
  StoreLinkOptions options_;
  std::map<LocalMapId, std::unique_ptr<GuardedMap>> maps_;
  FakeMapJobs jobs_;
  std::unique_ptr<StoreLink> manager_;
};

TEST_F(StoreLinkBudgetTest, PointsComeWhenAllKeyframesAreThere) {
  StartRobot();
  AddMap(kOwn);
  Run(absl::Seconds(5));
  EXPECT_GE(Told(UpdateKind::kKeyframes), 5u);
  EXPECT_LT(Told(UpdateKind::kKeyframes), 10u);
  EXPECT_EQ(Told(UpdateKind::kPoints), 0u);
  const HeldBack held = manager_->upload().held_back;
  EXPECT_EQ(held.items[1], 10 - Told(UpdateKind::kKeyframes));
  EXPECT_EQ(held.items[2], 200u);
  EXPECT_GE(held.waited[2], absl::Seconds(4));
  Run(absl::Seconds(20));
  EXPECT_EQ(Told(UpdateKind::kKeyframes), 10u);
  EXPECT_EQ(Told(UpdateKind::kPoints), 200u);
  EXPECT_TRUE(manager_->upload().held_back.IsNothing());
  ExpectEachKeyframeOnce(kOwn, 10);
}

TEST_F(StoreLinkBudgetTest, PosesPassWhatWaits) {
  StartRobot();
  AddKeyframe({kOwn, 0});
  Run(absl::Seconds(2));
  for (uint32_t k = 1; k <= 10; ++k) AddKeyframe({kOwn, k});
  for (int second = 0; second < 5; ++second) {
    manager_->AddTrackedFrame({second, {kOwn, 0}, {}});
    maps_[kOwn]->Write([&](Map& map) {
      map.SetPose({kOwn, 0}, {Eigen::Quaterniond::Identity(), {0.1 * second, 0, 0}});
    });
    Run(absl::Seconds(1.5));
    // The frame goes with the next batch, though keyframes wait.
    EXPECT_EQ(uplink_.stored[kOwn].back().full_points.size(), 0u);
    size_t frames = 0;
    for (const MapUpdateBatch* batch : Batches()) frames += batch->tracked_frames.size();
    EXPECT_EQ(frames, static_cast<size_t>(second + 1));
  }
}

TEST_F(StoreLinkBudgetTest, WhatIsHeldBackCoalesces) {
  StartRobot();
  AddMap(kOwn);
  Run(absl::Seconds(30));
  ASSERT_TRUE(manager_->upload().held_back.IsNothing());
  const size_t light = Told(UpdateKind::kLightPoints);
  // Keyframes keep the link busy while a point moves again and again.
  for (uint32_t k = 20; k < 30; ++k) AddKeyframe({kOwn, k});
  for (int i = 1; i <= 50; ++i) {
    maps_[kOwn]->Write([&](Map& map) { map.SetPosition({kOwn, 7}, {0.1 * i, 0, 10}); });
    Run(absl::Milliseconds(100));
  }
  EXPECT_EQ(Told(UpdateKind::kLightPoints), light);
  Run(absl::Seconds(20));
  EXPECT_EQ(Told(UpdateKind::kLightPoints), light + 1);
}

TEST_F(StoreLinkBudgetTest, TheMeanHoldsWhateverBatchesTake) {
  // Run checks the mean; the estimates are wrong both ways.
  for (const double factor : {0.3, 3.0}) {
    uplink_.wire_factor = factor;
    uplink_.bytes = 0;
    uplink_.stored.clear();
    now_ = start_;
    StartRobot();
    AddMap(kOwn);
    Run(absl::Seconds(60));
    EXPECT_EQ(Told(UpdateKind::kPoints), 200u);
  }
}

TEST_F(StoreLinkBudgetTest, WhatIsSentAgainCountsAgain) {
  StartRobot();
  uplink_.acknowledge = false;
  AddMap(kOwn);
  Run(absl::Seconds(4));
  // The store loses all that it had.
  uplink_.stored.clear();
  uplink_.Break(absl::UnavailableError("cut"));
  now_ += absl::Minutes(1);
  const uint64_t before = uplink_.bytes;
  const absl::Time again = now_;
  uplink_.acknowledge = true;
  for (int i = 0; i < 20; ++i, now_ += absl::Milliseconds(100)) {
    manager_->Step();
    EXPECT_LE(
        uplink_.bytes - before,
        20000 + static_cast<uint64_t>(kBytesPerSecond * (1 + absl::ToDoubleSeconds(now_ - again))));
  }
  for (int i = 0; i < 300; ++i, now_ += absl::Milliseconds(100)) manager_->Step();
  ExpectEachKeyframeOnce(kOwn, 10);
  EXPECT_EQ(Told(UpdateKind::kPoints), 200u);
}

TEST_F(StoreLinkBudgetTest, ALinkThatTakesNothingIsGivenNothing) {
  StartRobot();
  AddKeyframe({kOwn, 0});
  Run(absl::Seconds(2));
  uplink_.waiting = 1;
  AddMap(kOwn);
  const size_t batches = Batches().size();
  Run(absl::Seconds(10));
  EXPECT_EQ(Batches().size(), batches);
  uplink_.waiting = 0;
  Run(absl::Seconds(30));
  EXPECT_EQ(Told(UpdateKind::kPoints), 200u);
}

TEST_F(StoreLinkBudgetTest, TheEndWaitsForTheBudgetAndSaysWhatIsLeft) {
  StartRobot();
  AddMap(kOwn);
  const absl::Status unfinished = manager_->Finish(absl::Milliseconds(1));
  ASSERT_TRUE(absl::IsDeadlineExceeded(unfinished)) << unfinished;
  EXPECT_THAT(unfinished.message(), AllOf(HasSubstr("a budget of 10000 bytes a second"),
                                          HasSubstr("200 points"), HasSubstr("keyframes")));
  Run(absl::Seconds(30));
  EXPECT_TRUE(manager_->Finish(absl::Seconds(1)).ok());
  ExpectEachKeyframeOnce(kOwn, 10);
  EXPECT_EQ(Told(UpdateKind::kPoints), 200u);
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
  size_t closing = 0;
  for (const MapUpdateBatch* batch : Batches()) closing += batch->closes_local_map;
  EXPECT_EQ(closing, 1u);
}

TEST_F(StoreLinkBudgetTest, ALocalMapThatEndedTakesTurnsWithTheNext) {
  StartRobot();
  AddMap(kOwn);
  Run(absl::Seconds(2));
  Begin(kNext);
  AddMap(kNext);
  Run(absl::Seconds(6));
  EXPECT_FALSE(uplink_.stored[kNext].empty());
  EXPECT_FALSE(uplink_.stored[kOwn].back().closes_local_map);
  Run(absl::Seconds(60));
  EXPECT_TRUE(uplink_.stored[kOwn].back().closes_local_map);
  ExpectEachKeyframeOnce(kOwn, 10);
  ExpectEachKeyframeOnce(kNext, 10);
  EXPECT_EQ(Told(UpdateKind::kPoints), 400u);
}

// Without a place to keep batches, none is made before it can go.
TEST_F(StoreLinkBudgetTest, WithoutASessionChangesWaitInTheMap) {
  uplink_.reachable = false;
  StartRobot();
  AddMap(kOwn);
  Run(absl::Minutes(2));
  EXPECT_LE(manager_->upload().batches, 1u);
  uplink_.reachable = true;
  Run(absl::Minutes(1));
  ExpectEachKeyframeOnce(kOwn, 10);
  EXPECT_EQ(Told(UpdateKind::kPoints), 200u);
}

// A process that dies would lose what is not on the disk.
TEST_F(StoreLinkBudgetTest, WithoutASessionASpoolTakesAllThereIs) {
  uplink_.reachable = false;
  StartRobot(*OpenFakeSpool(&disk_));
  AddMap(kOwn);
  manager_->Step();
  EXPECT_TRUE(manager_->upload().held_back.IsNothing());
  EXPECT_GT(manager_->upload().spool_bytes, 10 * kKeypoints * 30);
  uplink_.reachable = true;
  // Eight keyframes are one batch by now, which is more at once than Run allows.
  for (int i = 0; i < 600; ++i, now_ += absl::Milliseconds(100)) manager_->Step();
  ExpectEachKeyframeOnce(kOwn, 10);
  EXPECT_EQ(Told(UpdateKind::kPoints), 200u);
}

TEST_F(StoreLinkBudgetTest, AtTheEndOfTheProcessTheSpoolHasWhatWasHeldBack) {
  StartRobot(*OpenFakeSpool(&disk_));
  manager_->Step();
  AddMap(kOwn);
  Run(absl::Seconds(1));
  ASSERT_FALSE(manager_->upload().held_back.IsNothing());
  manager_.reset();
  size_t keyframes = Told(UpdateKind::kKeyframes);
  size_t points = Told(UpdateKind::kPoints);
  const auto spool = OpenFakeSpool(&disk_);
  ASSERT_TRUE(spool.ok());
  for (const SpooledBatch& found : (*spool)->TakeFound()) {
    const auto batch = (*spool)->Read(found);
    ASSERT_TRUE(batch.ok());
    keyframes += batch->full_keyframes.size();
    points += batch->full_points.size();
  }
  EXPECT_EQ(keyframes, 10u);
  EXPECT_EQ(points, 200u);
}

TEST_F(StoreLinkBudgetTest, TheStoreIsToldWhatItMaySend) {
  StartRobot();
  manager_->Step();
  ASSERT_EQ(uplink_.requests.size(), 1u);
  EXPECT_EQ(uplink_.requests[0].downlink_bytes_per_second, 77u);
  EXPECT_EQ(uplink_.requests[0].share, ShareScope());
}

TEST_F(StoreLinkBudgetTest, TheStoreIsToldWhatTheRobotWantsToHear) {
  options_.share = {ShareMode::kNearby, 12};
  StartRobot();
  manager_->Step();
  ASSERT_EQ(uplink_.requests.size(), 1u);
  EXPECT_EQ(uplink_.requests[0].share, (ShareScope{ShareMode::kNearby, 12}));
}

TEST_F(StoreLinkBudgetTest, AnotherScopeOpensTheSessionAnew) {
  StartRobot();
  manager_->Step();
  manager_->SetShare(ShareScope());
  manager_->Step();
  EXPECT_EQ(uplink_.requests.size(), 1u) << "nothing has changed";
  manager_->SetShare({ShareMode::kCorrections});
  manager_->Step();
  ASSERT_EQ(uplink_.requests.size(), 2u);
  EXPECT_EQ(uplink_.requests[1].share.mode, ShareMode::kCorrections);
}

TEST_F(StoreLinkBudgetTest, ARateThatChangesHoldsFromThenOn) {
  StartRobot();
  AddMap(kOwn);
  manager_->Step();
  ASSERT_LT(Told(UpdateKind::kKeyframes), 10u);
  manager_->SetUplinkRate(0);
  manager_->Step();
  EXPECT_EQ(Told(UpdateKind::kKeyframes), 10u);
}

TEST_F(StoreLinkBudgetTest, TheThreadKeepsToItToo) {
  options_.flush_interval = absl::Milliseconds(1);
  StartRobot();
  AddMap(kOwn);
  manager_->Start();
  EXPECT_TRUE(absl::IsDeadlineExceeded(manager_->Finish(absl::Milliseconds(200))));
  manager_.reset();
  EXPECT_LT(Told(UpdateKind::kKeyframes), 10u);
}

}  // namespace
}  // namespace corbslam::client_agent
