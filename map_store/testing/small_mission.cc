#include "map_store/testing/small_mission.h"

#include <memory>
#include <string>
#include <utility>

namespace corbslam::testing {
namespace {

using map_store::AdjustRecord;
using map_store::BatchRecord;
using map_store::FuseRecord;
using map_store::FuseRefusedRecord;
using map_store::JournalRecord;
using map_store::QueryRecord;
using map_store::RevisionPlan;

constexpr uint32_t kKeyframes = 4;
constexpr uint32_t kPoints = 6;
constexpr absl::Time kThen = absl::UnixEpoch();

FullKeyframe MakeKeyframe(LocalMapId local_map, uint32_t index) {
  auto payload = std::make_shared<KeyframePayload>();
  payload->id = {local_map, index};
  payload->timestamp_ns = index;
  payload->features = MakeSmallFeatures();
  const KeyframeId parent = index == 0 ? KeyframeId() : KeyframeId{local_map, index - 1};
  return {payload, {Eigen::Quaterniond::Identity(), {-1.0 * index, 0, 0}}, parent};
}

MapUpdateBatch MakeFirstBatch(LocalMapId local_map) {
  MapUpdateBatch batch;
  batch.local_map = local_map;
  batch.number = 1;
  batch.cameras = {std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})};
  if (local_map == kSmallMapA) {
    batch.recorded_cameras = {{{400, 400, 322, 238, RadialTangential{-0.2, 0.05, 0, 0, 0}},
                               {},
                               Rigid3d{Eigen::Quaterniond::Identity(), {0.1, 0, 0}}}};
  }
  for (uint32_t k = 0; k < kKeyframes; ++k) {
    batch.full_keyframes.push_back(MakeKeyframe(local_map, k));
    batch.tracked_frames.push_back({k, {local_map, k}, {}});
  }
  for (uint32_t p = 0; p < kPoints; ++p) {
    FullMapPoint point;
    point.id = {local_map, p};
    point.position_in_local = {0.1 * p, 0, 5};
    point.reference = {local_map, 0};
    point.max_distance = 10;
    batch.full_points.push_back(point);
    for (uint32_t k = 0; k < 2; ++k) {
      batch.observations.push_back({ObservationChange::Kind::kAdded, point.id, {local_map, k}, p});
    }
  }
  batch.loop_edges = {{{local_map, 0}, {local_map, 2}, {}}};
  return batch;
}

// Returns a batch with changes of every kind.
MapUpdateBatch MakeSecondBatch(LocalMapId local_map, LocalMapId other) {
  using Kind = ObservationChange::Kind;
  MapUpdateBatch batch;
  batch.local_map = local_map;
  batch.number = 2;
  batch.light_keyframes = {{{local_map, 1}, {Eigen::Quaterniond::Identity(), {-1, 0.1, 0}}, {}}};
  batch.light_points = {{{local_map, 0}, {0, 0, 4}}};
  batch.replacements = {{{local_map, 5}, {local_map, 4}}};
  batch.observations = {{Kind::kRemoved, {local_map, 2}, {local_map, 1}, 2},
                        {Kind::kAdded, {other, 0}, {local_map, 1}, 6},
                        {Kind::kAdded, {local_map, 99}, {local_map, 1}, 7}};
  batch.removed_points = {{local_map, 3}};
  batch.removed_keyframes = {{{local_map, 3}, {local_map, 2}, {}}};
  batch.loop_edges = {{{local_map, 1}, {other, 1}, {}}};
  batch.lost_frames_ns = {7};
  batch.closes_local_map = true;
  return batch;
}

JournalRecord ToRecord(const std::string& agent, MapUpdateBatch batch) {
  return BatchRecord{agent, std::make_shared<const MapUpdateBatch>(std::move(batch)), kThen};
}

QueryRecord MakeQuery(uint32_t query, uint32_t candidate) {
  QueryRecord record;
  record.task = {{kSmallMapB, query}, kSmallMapA, 0};
  Overlap overlap;
  overlap.query = record.task.query;
  overlap.candidate = {kSmallMapA, candidate};
  overlap.covariance.diagonal() << 1e-4, 4e-4, 1e-4, 1e-6, 1e-6, 4e-6, 0;
  overlap.inliers = {{{kSmallMapB, 1}, {kSmallMapA, 1}}};
  overlap.verdict = OverlapVerdict::kAccepted;
  record.overlaps = {overlap};
  record.verified_at = kThen;
  return record;
}

RevisionPlan MakePlan(uint64_t revision) {
  RevisionPlan plan;
  plan.revision = revision;
  plan.target = kSmallMapA;
  for (const LocalMapId& local_map : {kSmallMapA, kSmallMapB}) {
    for (uint32_t k = 0; k < 2; ++k) plan.keyframes[{local_map, k}] = {{}, {}, revision};
    for (uint32_t p = 0; p < 2; ++p) {
      plan.points[{local_map, p}] = {Eigen::Vector3d(0.1 * p, 0, 5), revision};
    }
  }
  return plan;
}

JournalRecord MakeFuse() {
  FuseRecord record;
  record.plan = MakePlan(1);
  record.plan.source = kSmallMapB;
  record.plan.merges = {{{kSmallMapA, 1}, {kSmallMapB, 1}}};
  record.plan.rejected_raw[{{kSmallMapA, 0}, 2}] = {kSmallMapA, 2};
  record.plan.overlaps = {1};
  record.merge_ms = 12;
  return record;
}

JournalRecord MakeAdjust() {
  AdjustRecord record;
  record.plan = MakePlan(2);
  record.plan.decided_anew = {{kSmallMapA, 0}};
  record.statistics = {4, 9, 3, 1.5};
  return record;
}

}  // namespace

Features MakeSmallFeatures() {
  Features features;
  features.keypoints.resize(8);
  features.descriptors.resize(8);
  return features;
}

std::vector<JournalRecord> MakeSmallMission() {
  return {ToRecord("a", MakeFirstBatch(kSmallMapA)),
          ToRecord("b", MakeFirstBatch(kSmallMapB)),
          MakeQuery(0, 0),
          MakeFuse(),
          ToRecord("a", MakeSecondBatch(kSmallMapA, kSmallMapB)),
          MakeAdjust(),
          MakeQuery(1, 1),
          FuseRefusedRecord{kSmallMapA, {2}, {kSmallMapB}, 99}};
}

}  // namespace corbslam::testing
