// Holds what is said of a mission's memory against what the allocator gave for it.
#include <gtest/gtest.h>
#include <malloc.h>

#include <memory>
#include <random>
#include <utility>

#include "map_store/state/mission_state.h"
#include "map_store/view/memory_estimate.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kLocalMap{1};
constexpr LocalMapId kOther{2};

uint64_t Allocated() {
  const struct mallinfo2 allocated = mallinfo2();
  return allocated.uordblks + allocated.hblkhd;
}

// Makes keyframes of a drive: each sees what the last ones saw, and some that is new.
class Drive {
 public:
  Drive(LocalMapId id, size_t features, MissionState& state)
      : features_(features), local_map_(AddLocalMap(state, id, "a")), random_(id.value) {
    state.agents["a"].local_maps.push_back(id);
    local_map_.cameras = {camera_};
  }

  void Add(size_t keyframes) {
    for (size_t i = 0; i < keyframes; ++i) AddKeyframe();
  }

 private:
  static constexpr uint32_t kSeenFor = 5;

  std::shared_ptr<const Words> MakeWords() {
    constexpr uint32_t kWords = 100'000;
    constexpr uint32_t kNodes = 100;
    std::map<uint32_t, float> bag;
    while (bag.size() < features_ * 9 / 10) bag[static_cast<uint32_t>(random_()) % kWords] = 0.1F;
    auto words = std::make_shared<Words>();
    for (const auto& [word, weight] : bag) words->bag.push_back({word, weight});
    words->bag.shrink_to_fit();
    for (uint32_t node = 0; node < kNodes; ++node) {
      words->direct_index.push_back({node, std::vector<uint32_t>(features_ / kNodes)});
    }
    words->direct_index.shrink_to_fit();
    return words;
  }

  void AddKeyframe() {
    const KeyframeId id{local_map_.id, next_keyframe_++};
    Features features;
    features.keypoints.resize(features_);
    features.descriptors.resize(features_);
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(id, id.index, 0, camera_, std::move(features));
    keyframe.words = MakeWords();
    if (id.index > 0) keyframe.parent = {local_map_.id, id.index - 1};
    local_map_.database.Add(id, keyframe.words);
    local_map_.map.AddKeyframe(std::move(keyframe));
    local_map_.arrival[id] = local_map_.arrived.size();
    local_map_.arrived.push_back(id);
    AddPoints(id);
    local_map_.frames.resize(local_map_.frames.size() + 4);
  }

  // A tenth of the keypoints sees new points; each of these is seen by the next keyframes, too.
  void AddPoints(KeyframeId id) {
    const auto each = static_cast<uint32_t>(features_ / 10);
    for (uint32_t i = 0; i < each; ++i) {
      MapPoint point;
      point.id = {local_map_.id, next_point_++};
      point.reference = id;
      local_map_.followers.Add(id, point.id);
      local_map_.map.AddPoint(std::move(point));
    }
    const uint32_t seen = std::min(next_point_, kSeenFor * each);
    for (uint32_t i = 0; i < seen; ++i) {
      local_map_.map.AddObservation({local_map_.id, next_point_ - 1 - i}, id, i);
    }
  }

  const size_t features_;
  LocalMapState& local_map_;
  const std::shared_ptr<const Camera> camera_ = std::make_shared<const Camera>(Camera{
      .fx_px = 700, .fy_px = 700, .cx_px = 620, .cy_px = 188, .width_px = 1241, .height_px = 376});
  std::mt19937_64 random_;
  uint32_t next_keyframe_ = 0;
  uint32_t next_point_ = 0;
};

void Place(MissionState& state) {
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe, value] : local_map.map.keyframes()) {
      state.global.keyframes[keyframe].revision = 1;
    }
    for (const auto& [point, value] : local_map.map.points()) {
      state.global.points[point].revision = 1;
    }
    FindPoses(state, local_map);
  }
}

// Every second point of the one is one of the other.
void Join(MissionState& state) {
  for (const auto& [point, value] : state.FindLocalMap(kOther)->map.points()) {
    if (point.index % 2 == 0) state.global.landmarks.Merge({kLocalMap, point.index}, point);
  }
  for (uint64_t i = 1; i < 200; ++i) {
    OverlapEntry entry;
    entry.id = i;
    entry.overlap.query = {kLocalMap, 0};
    entry.overlap.candidate = {kOther, 0};
    entry.overlap.inliers.resize(50);
    state.global.overlaps.Add(std::move(entry));
  }
}

class MeasuredMissionTest : public ::testing::TestWithParam<size_t> {};

TEST_P(MeasuredMissionTest, WhatIsSaidIsWhatTheAllocatorGave) {
  constexpr size_t kKeyframes = 120;
  const uint64_t before = Allocated();
  auto state = std::make_unique<MissionState>();
  for (const LocalMapId& id : {kLocalMap, kOther}) {
    Drive drive(id, GetParam(), *state);
    drive.Add(kKeyframes);
  }
  Place(*state);
  Join(*state);
  const auto taken = static_cast<double>(Allocated() - before);
  const auto said = static_cast<double>(EstimateMemory(*state));
  EXPECT_NEAR(said / taken, 1, 0.1) << said << " for " << taken;
}

TEST(MeasuredMemoryTest, ALocalMapThatHasGoneHasNoPoses) {
  MissionState state;
  Drive(kLocalMap, 100, state).Add(20);
  Place(state);
  const uint64_t with = EstimateMemory(state);
  state.poses.Add(kLocalMap, nullptr);
  EXPECT_EQ(state.poses.Find(kLocalMap), nullptr);
  EXPECT_LE(EstimateMemory(state), with - 20 * sizeof(PoseTable::Standing));
}

INSTANTIATE_TEST_SUITE_P(Features, MeasuredMissionTest, ::testing::Values(300, 1000, 2000),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace corbslam::map_store
