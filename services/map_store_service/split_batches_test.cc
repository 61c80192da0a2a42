// What a robot's recorder makes of a backlog that is too large for one batch, and the store's own
// checks: it takes each batch, nothing of any refers to what comes later, and the tree comes to be
// the robot's.
#include <gtest/gtest.h>

#include <cstdint>
#include <iterator>
#include <memory>
#include <random>
#include <utility>

#include "client_agent/upload/outbox.h"
#include "client_agent/upload/update_recorder.h"
#include "map_store/store/map_store.h"
#include "services/convert/testing/test_data.h"

namespace corbslam::services {

using client_agent::BatchLimits;
using client_agent::IsEmpty;
using client_agent::RecorderOptions;
using client_agent::ToString;
using client_agent::UpdateRecorder;
using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

constexpr LocalMapId kOwn{0x11};
constexpr uint32_t kKeypoints = 20;

constexpr BatchLimits kTinyLimits = {.full_points = 3,
                                     .light_keyframes = 2,
                                     .light_points = 2,
                                     .replacements = 1,
                                     .observations = 4,
                                     .removed_points = 1,
                                     .removed_keyframes = 1,
                                     .loop_edges = 1,
                                     .frames = 1};

class SplitBatchesTest : public ::testing::Test {
 protected:
  SplitBatchesTest() : store_(Options(), nullptr, std::make_unique<InMemoryJournal>(), nullptr) {
    map_.SetObserver(&recorder_);
    SessionRequest request;
    request.mission = "m";
    request.agent = "alpha";
    session_ = store_.OpenSession(request)->session_id;
  }

  static MapStoreOptions Options() {
    MapStoreOptions options;
    options.deterministic = true;
    return options;
  }

  void AddKeyframe(KeyframeId parent) {
    Keyframe keyframe;
    keyframe.payload = test_data::MakePayload(random_, {kOwn, next_keyframe_++}, kKeypoints);
    keyframe.parent = parent;
    map_.AddKeyframe(std::move(keyframe));
  }
  void AddPoint() {
    MapPoint point;
    point.id = {kOwn, next_point_++};
    point.reference = AnyKeyframe();
    point.position_in_map = {0, 0, 5};
    map_.AddPoint(point);
    map_.AddObservation(point.id, point.reference, AnyKeypoint());
  }
  uint32_t AnyKeypoint() { return static_cast<uint32_t>(random_()) % kKeypoints; }
  KeyframeId AnyKeyframe() {
    const auto index = static_cast<ptrdiff_t>(random_() % map_.keyframes().size());
    return std::next(map_.keyframes().begin(), index)->first;
  }
  MapPointId AnyPoint() {
    const auto index = static_cast<ptrdiff_t>(random_() % map_.points().size());
    return std::next(map_.points().begin(), index)->first;
  }

  // One batch; false: there is nothing more to tell.
  bool Upload() {
    MapUpdateBatch batch = recorder_.TakeBatch(map_, 1);
    if (IsEmpty(batch)) return false;
    batch.number = ++batches_;
    const auto acknowledged = store_.Apply(session_, batch);
    EXPECT_TRUE(acknowledged.ok()) << acknowledged.status();
    const auto info = store_.GetLocalMap("m", kOwn);
    EXPECT_TRUE(info.ok()) << info.status();
    EXPECT_EQ(info->parked_references, 0u) << "batch " << batches_;
    return acknowledged.ok();
  }
  void UploadAll() {
    while (Upload()) {
    }
    EXPECT_FALSE(recorder_.HasChanges());
    ExpectSameTree();
  }

  void ExpectSameTree() const {
    EXPECT_EQ(store_.GetLocalMap("m", kOwn)->keyframes, map_.keyframes().size());
    for (const auto& [id, keyframe] : map_.keyframes()) {
      const auto stored = store_.GetKeyframe("m", id);
      ASSERT_TRUE(stored.ok()) << stored.status();
      EXPECT_EQ(stored->parent, keyframe.parent) << ToString(id);
      EXPECT_LT(
          (stored->camera_from_local.translation - keyframe.camera_from_map.translation).norm(),
          1e-9)
          << ToString(id);
    }
  }

  std::mt19937 random_{1};
  UpdateRecorder recorder_{kOwn, RecorderOptions{.hold_newest = 0, .limits = kTinyLimits}};
  Map map_;
  MapStore store_;
  uint64_t session_ = 0;
  uint64_t batches_ = 0;
  uint32_t next_keyframe_ = 0;
  uint32_t next_point_ = 0;
};

// Each keyframe comes to hang on the one that hung on it: in any other order than from the new root
// on, the first steps would make cycles, which a store leaves out for good.
TEST_F(SplitBatchesTest, AChainThatIsTurnedAroundGoesUpInPieces) {
  constexpr uint32_t kChain = 30;
  AddKeyframe({});
  for (uint32_t i = 1; i < kChain; ++i) AddKeyframe({kOwn, i - 1});
  UploadAll();
  const auto turn_around = [&](bool backwards) {
    const uint32_t first = backwards ? kChain - 1 : 1;
    EXPECT_TRUE(map_.SetParent({kOwn, first}, {kOwn, 0}));
    for (uint32_t i = 2; i < kChain; ++i) {
      const uint32_t child = backwards ? kChain - i : i;
      EXPECT_TRUE(map_.SetParent({kOwn, child}, {kOwn, backwards ? child + 1 : child - 1}));
    }
  };
  turn_around(true);
  UploadAll();
  // And back, of which the store has heard a part when it is turned again.
  turn_around(false);
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(Upload());
  turn_around(true);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(Upload());
  turn_around(false);
  UploadAll();
}

TEST_F(SplitBatchesTest, AKeyframeGoesWhenItsChildrenHangOnOthers) {
  AddKeyframe({});
  AddKeyframe({kOwn, 0});
  for (uint32_t i = 2; i < 12; ++i) AddKeyframe({kOwn, 1});
  UploadAll();
  map_.RemoveKeyframe({kOwn, 1});
  map_.RemoveKeyframe({kOwn, 5});
  UploadAll();
  EXPECT_FALSE(store_.GetKeyframe("m", {kOwn, 1}).ok());
}

TEST_F(SplitBatchesTest, WhateverHappensTheStoreTakesEachBatch) {
  AddKeyframe({});
  for (int i = 0; i < 30; ++i) AddKeyframe(AnyKeyframe());
  for (int i = 0; i < 10; ++i) AddPoint();
  for (int step = 0; step < 2000 && !HasFailure(); ++step) {
    const KeyframeId id = AnyKeyframe();
    switch (random_() % 8) {
      case 0:
        if (map_.keyframes().size() < 60) AddKeyframe(id);
        break;
      case 1:
        AddPoint();
        break;
      case 2:
        map_.AddObservation(AnyPoint(), id, AnyKeypoint());
        break;
      case 3:
        map_.ReplacePoint(AnyPoint(), AnyPoint());
        break;
      case 4:
        if (map_.points().size() > 5) map_.RemovePoint(AnyPoint());
        break;
      case 5:
        // Mapping never takes the root out.
        if (id.index != 0 && map_.keyframes().size() > 20) map_.RemoveKeyframe(id);
        break;
      case 6:
        map_.AddLoopEdge(id, AnyKeyframe());
        break;
      default:
        map_.SetPose(id, {Eigen::Quaterniond::Identity(), {0.01 * step, 0, 0}});
        if (id.index != 0) map_.SetParent(id, AnyKeyframe());
    }
    if (random_() % 5 == 0) Upload();
    if (step % 500 == 499) UploadAll();
  }
}

}  // namespace
}  // namespace corbslam::services
