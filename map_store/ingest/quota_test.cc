#include "map_store/ingest/quota.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kFullMap{0xa};

MapUpdateBatch Empty() {
  MapUpdateBatch batch;
  batch.local_map = kFullMap;
  batch.number = 7;
  return batch;
}

MapUpdateBatch WithKeyframe(size_t keypoints) {
  MapUpdateBatch batch = Empty();
  Features features;
  features.keypoints.resize(keypoints);
  features.descriptors.resize(keypoints);
  FullKeyframe keyframe;
  keyframe.payload =
      MakeKeyframePayload({kFullMap, 0}, 0, 0, std::make_shared<const Camera>(), features);
  batch.full_keyframes.push_back(keyframe);
  return batch;
}

MissionState MakeState(uint64_t alphas, uint64_t alphas_second, uint64_t bravos) {
  MissionState state;
  state.name = "lab";
  uint64_t id = 1;
  for (const auto& [agent, bytes] :
       {std::pair("alpha", alphas), {"alpha", alphas_second}, {"bravo", bravos}}) {
    LocalMapState& local_map = state.local_maps[LocalMapId{id}];
    local_map.id = LocalMapId{id++};
    local_map.agent = agent;
    local_map.stored_bytes = bytes;
  }
  return state;
}

TEST(StoredBytesTest, EachKindOfItemCounts) {
  const uint64_t none = StoredBytes(Empty());
  EXPECT_EQ(none, 0u);
  MapUpdateBatch all = WithKeyframe(3);
  uint64_t bytes = StoredBytes(all);
  EXPECT_EQ(bytes, sizeof(Keyframe) + 3 * (sizeof(Keypoint) + sizeof(Descriptor)));
  const auto two_more = [&](auto& items) {
    const uint64_t before = bytes;
    items.resize(2);
    bytes = StoredBytes(all);
    return bytes - before;
  };
  EXPECT_EQ(two_more(all.cameras), 2 * sizeof(Camera));
  EXPECT_EQ(two_more(all.full_points), 2 * sizeof(MapPoint));
  EXPECT_EQ(two_more(all.replacements), 2 * sizeof(PointReplacement));
  EXPECT_EQ(two_more(all.observations), 2 * sizeof(ObservationChange));
  EXPECT_EQ(two_more(all.removed_points), 2 * sizeof(MapPointId));
  EXPECT_EQ(two_more(all.removed_keyframes), 2 * sizeof(KeyframeRemoval));
  EXPECT_EQ(two_more(all.loop_edges), 2 * sizeof(LoopEdge));
  EXPECT_EQ(two_more(all.tracked_frames), 2 * sizeof(TrackedFrame));
  EXPECT_EQ(two_more(all.lost_frames_ns), 2 * sizeof(int64_t));
}

TEST(StoredBytesTest, AKeyframeWithoutItsPictureIsNotCounted) {
  MapUpdateBatch batch = Empty();
  batch.full_keyframes.resize(1);
  EXPECT_EQ(StoredBytes(batch), 0u);
}

TEST(StoredBytesTest, ATrajectorysFramesCount) {
  LocalisedFrames part;
  const uint64_t empty = StoredBytes(part);
  part.tracked_frames.resize(3);
  part.lost_frames_ns.resize(2);
  EXPECT_EQ(StoredBytes(part), empty + 3 * sizeof(TrackedFrame) + 2 * sizeof(int64_t));
}

TEST(CheckQuotaTest, AnAgentMayStoreUpToItsLimitInAllItsLocalMaps) {
  const MapUpdateBatch batch = WithKeyframe(10);
  const uint64_t more = StoredBytes(batch);
  MapStoreOptions options;
  options.max_bytes_per_agent = 1000 + 200 + more;
  options.max_bytes_per_mission = 1'000'000;
  EXPECT_TRUE(CheckQuota(MakeState(1000, 200, 5000), "alpha", batch, options).ok());
  const absl::Status refused = CheckQuota(MakeState(1000, 201, 0), "alpha", batch, options);
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(refused.message(), HasSubstr("agent alpha has 1201 bytes"));
  EXPECT_THAT(refused.message(), HasSubstr("batch 7"));
  // What others have is not its own.
  EXPECT_TRUE(CheckQuota(MakeState(1000, 201, 0), "bravo", batch, options).ok());
  // More than the limit already: nothing overflows.
  EXPECT_FALSE(CheckQuota(MakeState(500'000, 0, 0), "alpha", batch, options).ok());
}

TEST(CheckQuotaTest, AMissionMayStoreUpToItsLimitWhoeverStores) {
  const MapUpdateBatch batch = WithKeyframe(10);
  MapStoreOptions options;
  options.max_bytes_per_agent = 1'000'000;
  options.max_bytes_per_mission = 1000 + 200 + 30 + StoredBytes(batch);
  EXPECT_TRUE(CheckQuota(MakeState(1000, 200, 30), "charlie", batch, options).ok());
  const absl::Status refused = CheckQuota(MakeState(1000, 200, 31), "charlie", batch, options);
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(refused.message(), HasSubstr("mission lab has 1231 bytes"));
}

}  // namespace
}  // namespace corbslam::map_store
