#include "client_agent/upload/held_items.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using Kind = SpoolRecord::Kind;

// What one batch takes, well below what a store refuses.
constexpr size_t kMaxHeldKeyframes = 8;
constexpr size_t kMaxHeldPoints = 8000;
constexpr size_t kMaxHeldObservations = 4000;
constexpr size_t kMaxHeldFrames = 30000;

bool IsHeld(const SpooledBatch& spooled) {
  return spooled.record.kind == Kind::kHeldKeyframe || spooled.record.kind == Kind::kHeldRest;
}

// What was found of one local map.
struct FoundOfMap {
  uint64_t last_batch = 0;
  bool is_closed = false;
  std::map<uint64_t, SpooledBatch> keyframes;
  std::optional<SpooledBatch> rest;
};

std::map<LocalMapId, FoundOfMap> SortFound(const std::vector<SpooledBatch>& found) {
  std::map<LocalMapId, FoundOfMap> sorted;
  for (const SpooledBatch& spooled : found) {
    FoundOfMap& of_map = sorted[spooled.record.local_map];
    switch (spooled.record.kind) {
      case Kind::kBatch:
        of_map.last_batch = std::max(of_map.last_batch, spooled.record.number);
        of_map.is_closed = of_map.is_closed || spooled.record.closes_local_map;
        break;
      case Kind::kHeldKeyframe:
        of_map.keyframes[spooled.record.number] = spooled;
        break;
      case Kind::kHeldRest:
        of_map.rest = spooled;
        break;
      case Kind::kWholePart:
      case Kind::kWholeEnd:
        of_map.last_batch = std::max(of_map.last_batch, spooled.record.number);
        break;
    }
  }
  return sorted;
}

// Splits a list over batches, each of which gets so many at most.
template <typename Item>
void Deal(const std::vector<Item>& items, size_t most, std::vector<Item> MapUpdateBatch::*field,
          std::vector<MapUpdateBatch>& batches) {
  for (size_t begin = 0; begin < items.size(); begin += most) {
    const size_t end = std::min(items.size(), begin + most);
    MapUpdateBatch& batch = batches.emplace_back();
    (batch.*field).assign(items.begin() + static_cast<ptrdiff_t>(begin),
                          items.begin() + static_cast<ptrdiff_t>(end));
  }
}

// Keyframes without a payload go with what names them.
absl::StatusOr<std::vector<FullKeyframe>> ReadHeldKeyframes(const FoundOfMap& found,
                                                            MapUpdateBatch& rest, Spool& spool) {
  std::vector<FullKeyframe> keyframes;
  for (const LightKeyframe& light : rest.light_keyframes) {
    const auto payload = found.keyframes.find(uint64_t{light.id.index} + 1);
    if (payload == found.keyframes.end()) {
      return absl::DataLossError(absl::StrCat("the spool has no payload of keyframe ",
                                              ToString(light.id), ", which was in no batch"));
    }
    ASSIGN_OR_RETURN(MapUpdateBatch batch, spool.Read(payload->second));
    if (batch.full_keyframes.size() != 1) return absl::DataLossError("a held keyframe is none");
    FullKeyframe& full = batch.full_keyframes.front();
    full.camera_from_local = light.camera_from_local;
    full.parent = light.parent;
    keyframes.push_back(std::move(full));
  }
  rest.light_keyframes.clear();
  return keyframes;
}

absl::StatusOr<std::vector<MapUpdateBatch>> MakeHeldBatches(const FoundOfMap& found, Spool& spool) {
  ASSIGN_OR_RETURN(MapUpdateBatch rest, spool.Read(*found.rest));
  ASSIGN_OR_RETURN(const std::vector<FullKeyframe> keyframes,
                   ReadHeldKeyframes(found, rest, spool));
  std::vector<MapUpdateBatch> batches;
  Deal(keyframes, kMaxHeldKeyframes, &MapUpdateBatch::full_keyframes, batches);
  Deal(rest.full_points, kMaxHeldPoints, &MapUpdateBatch::full_points, batches);
  Deal(rest.observations, kMaxHeldObservations, &MapUpdateBatch::observations, batches);
  Deal(rest.tracked_frames, kMaxHeldFrames, &MapUpdateBatch::tracked_frames, batches);
  Deal(rest.lost_frames_ns, kMaxHeldFrames, &MapUpdateBatch::lost_frames_ns, batches);
  uint64_t number = found.last_batch;
  for (MapUpdateBatch& batch : batches) {
    batch.local_map = rest.local_map;
    batch.number = ++number;
  }
  return batches;
}

absl::Status TellHeldOf(const FoundOfMap& found, Spool& spool, std::vector<SpooledBatch>& told) {
  ASSIGN_OR_RETURN(const std::vector<MapUpdateBatch> batches, MakeHeldBatches(found, spool));
  for (const MapUpdateBatch& batch : batches) {
    ASSIGN_OR_RETURN(const SpooledBatch spooled, spool.Append(batch));
    told.push_back(spooled);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status HeldWriter::Write(const HeldItems& held, uint64_t last_batch, Spool& spool) {
  if (last_batch == 0) return absl::OkStatus();
  for (const FullKeyframe& keyframe : held.keyframes) {
    MapUpdateBatch batch;
    batch.local_map = held.rest.local_map;
    batch.number = uint64_t{keyframe.payload->id.index} + 1;
    batch.full_keyframes.push_back(keyframe);
    ASSIGN_OR_RETURN(keyframes_[keyframe.payload->id], spool.Append(batch, Kind::kHeldKeyframe));
  }
  MapUpdateBatch rest = held.rest;
  rest.number = last_batch;
  ASSIGN_OR_RETURN(const SpooledBatch written, spool.Append(rest, Kind::kHeldRest));
  for (const SpooledBatch& before : rest_) spool.Release(before);
  rest_ = {written};
  std::set<KeyframeId> still;
  for (const LightKeyframe& light : rest.light_keyframes) still.insert(light.id);
  for (auto it = keyframes_.begin(); it != keyframes_.end();) {
    if (still.contains(it->first)) {
      ++it;
      continue;
    }
    spool.Release(it->second);
    it = keyframes_.erase(it);
  }
  return absl::OkStatus();
}

void HeldWriter::Release(Spool& spool) {
  for (const auto& [id, spooled] : keyframes_) spool.Release(spooled);
  for (const SpooledBatch& spooled : rest_) spool.Release(spooled);
  keyframes_.clear();
  rest_.clear();
}

absl::Status TellHeld(Spool& spool) {
  std::vector<SpooledBatch> found = spool.TakeFound();
  std::vector<SpooledBatch> told;
  absl::Status first_error;
  for (const auto& [id, of_map] : SortFound(found)) {
    // Later batches told it.
    const bool is_newest = of_map.rest.has_value() && !of_map.is_closed &&
                           of_map.rest->record.number == of_map.last_batch;
    if (is_newest) first_error.Update(TellHeldOf(of_map, spool, told));
  }
  if (!told.empty()) first_error.Update(spool.Sync());
  for (const SpooledBatch& spooled : found) {
    if (IsHeld(spooled)) spool.Release(spooled);
  }
  std::erase_if(found, IsHeld);
  found.insert(found.end(), told.begin(), told.end());
  spool.SetFound(std::move(found));
  return first_error;
}

}  // namespace corbslam::client_agent
