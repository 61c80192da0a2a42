#include "map_store/archive/record_archive.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "map_store/archive/state_fields.h"
#include "map_store/archive/unreadable.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

std::vector<uint32_t> CountKeypoints(const std::vector<FullKeyframe>& keyframes) {
  std::vector<uint32_t> counts;
  for (const FullKeyframe& keyframe : keyframes) {
    counts.push_back(static_cast<uint32_t>(keyframe.payload->features.keypoints.size()));
  }
  return counts;
}

absl::StatusOr<Features> LoadOrBlank(const FeatureLoader& load, KeyframeId id, uint32_t keypoints) {
  if (load != nullptr) return load(id);
  Features blank;
  blank.keypoints.resize(keypoints);
  blank.descriptors.resize(keypoints);
  return blank;
}

constexpr uint32_t kNoAnchor = std::numeric_limits<uint32_t>::max();

// Names each point's anchor by its rank among the plan's keyframes.
std::string EncodeAnchors(const RevisionPlan& plan) {
  absl::flat_hash_map<KeyframeId, uint32_t> ranks;
  for (const auto& [id, placed] : plan.keyframes) ranks.emplace(id, ranks.size());
  std::vector<uint32_t> anchors;
  anchors.reserve(plan.points.size());
  for (const auto& [id, planned] : plan.points) {
    const auto rank = ranks.find(planned.anchor);
    anchors.push_back(rank == ranks.end() ? kNoAnchor : rank->second);
  }
  ArchiveWriter writer;
  writer(anchors);
  return writer.Take();
}

absl::Status SetAnchors(const std::vector<uint32_t>& anchors, RevisionPlan& plan) {
  std::vector<KeyframeId> keyframes;
  keyframes.reserve(plan.keyframes.size());
  for (const auto& [id, placed] : plan.keyframes) keyframes.push_back(id);
  const bool sound =
      anchors.size() == plan.points.size() && std::ranges::all_of(anchors, [&](uint32_t rank) {
        return rank == kNoAnchor || rank < keyframes.size();
      });
  if (!sound) return Unreadable("what a plan's points are anchored in");
  auto rank = anchors.begin();
  for (auto& [id, planned] : plan.points) {
    planned.anchor = *rank == kNoAnchor ? KeyframeId() : keyframes[*rank];
    ++rank;
  }
  return absl::OkStatus();
}

RevisionPlan* PlanOf(JournalRecord& record) {
  if (auto* fuse = std::get_if<FuseRecord>(&record)) return &fuse->plan;
  if (auto* adjust = std::get_if<AdjustRecord>(&record)) return &adjust->plan;
  return nullptr;
}

// Writes what follows the record's fields.
void WriteTail(const BatchRecord& record, ArchiveWriter& writer) {
  writer(CountKeypoints(record.batch->full_keyframes), record.batch->recorded_cameras,
         record.batch->points_follow);
}
void WriteTail(std::string_view anchors, ArchiveWriter& writer) {
  writer.Raw(anchors.data(), anchors.size());
}

}  // namespace

PlanBytes EncodePlan(const RevisionPlan& plan) {
  ArchiveWriter writer;
  writer(plan);
  return {writer.Take(), EncodeAnchors(plan)};
}

std::string EncodeRecord(const JournalRecord& record) {
  ArchiveWriter writer;
  writer(record);
  if (const auto* update = std::get_if<BatchRecord>(&record)) {
    WriteTail(*update, writer);
  } else if (const auto* fuse = std::get_if<FuseRecord>(&record)) {
    WriteTail(EncodeAnchors(fuse->plan), writer);
  } else if (const auto* adjust = std::get_if<AdjustRecord>(&record)) {
    WriteTail(
        adjust->plan_bytes != nullptr ? adjust->plan_bytes->anchors : EncodeAnchors(adjust->plan),
        writer);
  }
  return writer.Take();
}

absl::StatusOr<JournalRecord> DecodeRecord(std::string_view bytes, const FeatureLoader& load) {
  ArchiveReader reader(bytes);
  JournalRecord record;
  reader(record);
  auto* update = std::get_if<BatchRecord>(&record);
  std::vector<uint32_t> keypoints;
  std::vector<RecordedCamera> recorded_cameras;
  bool points_follow = false;
  if (update != nullptr && reader.ok()) reader(keypoints, recorded_cameras, points_follow);
  if (RevisionPlan* plan = PlanOf(record); plan != nullptr && reader.ok()) {
    std::vector<uint32_t> anchors;
    reader(anchors);
    RETURN_IF_ERROR(SetAnchors(anchors, *plan));
  }
  if (!reader.done()) return Unreadable("a journal record");
  if (update == nullptr) return record;
  auto batch = std::make_shared<MapUpdateBatch>(*update->batch);
  if (keypoints.size() != batch->full_keyframes.size()) return Unreadable("a journal record");
  batch->recorded_cameras = std::move(recorded_cameras);
  batch->points_follow = points_follow;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    auto payload = std::make_shared<KeyframePayload>(*batch->full_keyframes[i].payload);
    ASSIGN_OR_RETURN(payload->features, LoadOrBlank(load, payload->id, keypoints[i]));
    if (payload->features.keypoints.size() != keypoints[i]) return DifferentCount(payload->id);
    batch->full_keyframes[i].payload = std::move(payload);
  }
  update->batch = std::move(batch);
  return record;
}

}  // namespace corbslam::map_store
