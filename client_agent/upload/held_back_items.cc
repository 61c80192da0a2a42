#include "client_agent/upload/held_back_items.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using Kind = SpoolRecord::Kind;

// What one batch takes, well below what a store refuses.
constexpr size_t kMaxHeldBackKeyframes = 8;
constexpr size_t kMaxHeldBackPoints = 8000;
constexpr size_t kMaxHeldBackObservations = 4000;
constexpr size_t kMaxHeldBackFrames = 30000;

bool IsHeldBack(const SpooledBatch& spooled) {
  return spooled.record.kind == Kind::kHeldBackKeyframe ||
         spooled.record.kind == Kind::kHeldBackRest;
}

// Collects what the spool found of one local map.
struct FoundOfMap {
  uint64_t last_batch = 0;
  std::map<uint64_t, SpooledBatch> batches;
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
        of_map.batches[spooled.record.number] = spooled;
        of_map.is_closed = of_map.is_closed || spooled.record.closes_local_map;
        break;
      case Kind::kHeldBackKeyframe:
        of_map.keyframes[spooled.record.number] = spooled;
        break;
      case Kind::kHeldBackRest:
        of_map.rest = spooled;
        break;
      case Kind::kSnapshotPart:
      case Kind::kSnapshotEnd:
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
    (batch.*field)
        .assign(items.begin() + static_cast<ptrdiff_t>(begin),
                items.begin() + static_cast<ptrdiff_t>(end));
  }
}

// Collects what batches said that came after the record of what was held back.
struct ToldLater {
  std::set<KeyframeId> keyframes;
  std::map<KeyframeId, KeyframeId> parents_of_removed;
  std::set<MapPointId> points;
  std::set<MapPointId> gone_points;
  std::set<int64_t> frames_ns;
};

void NoteTold(const MapUpdateBatch& batch, ToldLater& told) {
  for (const FullKeyframe& full : batch.full_keyframes) told.keyframes.insert(full.payload->id);
  for (const KeyframeRemoval& removal : batch.removed_keyframes) {
    told.parents_of_removed[removal.id] = removal.parent;
  }
  for (const FullMapPoint& full : batch.full_points) told.points.insert(full.id);
  for (const PointReplacement& replacement : batch.replacements) {
    told.gone_points.insert(replacement.replaced);
  }
  told.gone_points.insert(batch.removed_points.begin(), batch.removed_points.end());
  for (const TrackedFrame& frame : batch.tracked_frames) told.frames_ns.insert(frame.timestamp_ns);
  told.frames_ns.insert(batch.lost_frames_ns.begin(), batch.lost_frames_ns.end());
}

// Takes out what was told or taken out meanwhile, and what hangs on it.
void LeaveOutTold(const ToldLater& told, MapUpdateBatch& rest) {
  const auto is_gone = [&](KeyframeId id) { return told.parents_of_removed.contains(id); };
  std::erase_if(rest.light_keyframes, [&](const LightKeyframe& light) {
    return told.keyframes.contains(light.id) || is_gone(light.id);
  });
  std::set<KeyframeId> left;
  for (LightKeyframe& light : rest.light_keyframes) {
    left.insert(light.id);
    // Each that is gone is stepped over once.
    for (size_t step = 0; step <= told.parents_of_removed.size() && is_gone(light.parent); ++step) {
      light.parent = told.parents_of_removed.at(light.parent);
    }
  }
  std::map<MapPointId, KeyframeId> seen_by;
  std::erase_if(rest.observations,
                [&](const ObservationChange& change) { return is_gone(change.keyframe); });
  for (const ObservationChange& change : rest.observations) {
    seen_by.emplace(change.point, change.keyframe);
  }
  std::set<MapPointId> gone = told.gone_points;
  for (FullMapPoint& full : rest.full_points) {
    const auto seen = seen_by.find(full.id);
    if (is_gone(full.reference) && seen != seen_by.end()) full.reference = seen->second;
    if (is_gone(full.reference)) gone.insert(full.id);
  }
  std::erase_if(rest.full_points, [&](const FullMapPoint& full) {
    return told.points.contains(full.id) || gone.contains(full.id);
  });
  std::set<MapPointId> new_points;
  for (const FullMapPoint& full : rest.full_points) new_points.insert(full.id);
  std::erase_if(rest.observations, [&](const ObservationChange& change) {
    return !new_points.contains(change.point) &&
           (!left.contains(change.keyframe) || gone.contains(change.point));
  });
  std::erase_if(rest.tracked_frames, [&](const TrackedFrame& frame) {
    return told.frames_ns.contains(frame.timestamp_ns) || is_gone(frame.reference);
  });
  std::erase_if(rest.lost_frames_ns,
                [&](int64_t lost_ns) { return told.frames_ns.contains(lost_ns); });
}

// Keyframes without a payload go with what names them.
absl::StatusOr<std::vector<FullKeyframe>> ReadHeldBackKeyframes(const FoundOfMap& found,
                                                                MapUpdateBatch& rest,
                                                                Spool& spool) {
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

// Batches that were written after the record, but for which it was not written anew yet.
bool HasAllLater(const FoundOfMap& found) {
  for (uint64_t number = found.rest->record.number + 1; number <= found.last_batch; ++number) {
    if (!found.batches.contains(number)) return false;
  }
  return true;
}

absl::StatusOr<std::vector<MapUpdateBatch>> MakeHeldBackBatches(const FoundOfMap& found,
                                                                Spool& spool) {
  ASSIGN_OR_RETURN(MapUpdateBatch rest, spool.Read(*found.rest));
  ToldLater told;
  for (auto it = found.batches.upper_bound(rest.number); it != found.batches.end(); ++it) {
    ASSIGN_OR_RETURN(const MapUpdateBatch batch, spool.Read(it->second));
    NoteTold(batch, told);
  }
  LeaveOutTold(told, rest);
  ASSIGN_OR_RETURN(const std::vector<FullKeyframe> keyframes,
                   ReadHeldBackKeyframes(found, rest, spool));
  std::vector<MapUpdateBatch> batches;
  Deal(keyframes, kMaxHeldBackKeyframes, &MapUpdateBatch::full_keyframes, batches);
  Deal(rest.full_points, kMaxHeldBackPoints, &MapUpdateBatch::full_points, batches);
  Deal(rest.observations, kMaxHeldBackObservations, &MapUpdateBatch::observations, batches);
  Deal(rest.tracked_frames, kMaxHeldBackFrames, &MapUpdateBatch::tracked_frames, batches);
  Deal(rest.lost_frames_ns, kMaxHeldBackFrames, &MapUpdateBatch::lost_frames_ns, batches);
  uint64_t number = found.last_batch;
  for (MapUpdateBatch& batch : batches) {
    batch.local_map = rest.local_map;
    batch.number = ++number;
  }
  return batches;
}

absl::Status TellHeldBackOf(const FoundOfMap& found, Spool& spool,
                            std::vector<SpooledBatch>& told) {
  ASSIGN_OR_RETURN(const std::vector<MapUpdateBatch> batches, MakeHeldBackBatches(found, spool));
  for (const MapUpdateBatch& batch : batches) {
    ASSIGN_OR_RETURN(const SpooledBatch spooled, spool.Append(batch));
    told.push_back(spooled);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status HeldBackWriter::Write(const HeldBackItems& held_back, uint64_t last_batch,
                                   Spool& spool) {
  for (const FullKeyframe& keyframe : held_back.keyframes) {
    MapUpdateBatch batch;
    batch.local_map = held_back.rest.local_map;
    batch.number = uint64_t{keyframe.payload->id.index} + 1;
    batch.full_keyframes.push_back(keyframe);
    ASSIGN_OR_RETURN(keyframes_[keyframe.payload->id],
                     spool.Append(batch, Kind::kHeldBackKeyframe));
  }
  MapUpdateBatch rest = held_back.rest;
  rest.number = last_batch;
  ASSIGN_OR_RETURN(const SpooledBatch written, spool.Append(rest, Kind::kHeldBackRest));
  // They are needed until what was written now, which stands in for them, outlives a loss of power.
  for (const SpooledBatch& before : rest_) spool.ReleaseOnceSynced(before);
  rest_ = {written};
  std::set<KeyframeId> still;
  for (const LightKeyframe& light : rest.light_keyframes) still.insert(light.id);
  for (auto it = keyframes_.begin(); it != keyframes_.end();) {
    if (still.contains(it->first)) {
      ++it;
      continue;
    }
    spool.ReleaseOnceSynced(it->second);
    it = keyframes_.erase(it);
  }
  return absl::OkStatus();
}

void HeldBackWriter::Finish(Spool& spool) {
  for (const auto& [id, spooled] : keyframes_) spool.ReleaseOnceSynced(spooled);
  for (const SpooledBatch& spooled : rest_) spool.ReleaseOnceSynced(spooled);
  keyframes_.clear();
  rest_.clear();
}

void HeldBackWriter::Release(Spool& spool) {
  for (const auto& [id, spooled] : keyframes_) spool.Release(spooled);
  for (const SpooledBatch& spooled : rest_) spool.Release(spooled);
  keyframes_.clear();
  rest_.clear();
}

absl::Status TellHeldBack(Spool& spool) {
  std::vector<SpooledBatch> found = spool.TakeFound();
  std::vector<SpooledBatch> told;
  absl::Status first_error;
  for (const auto& [id, of_map] : SortFound(found)) {
    // The last batch of a local map stays until the map is closed and all of it acknowledged.
    const bool is_there = of_map.last_batch > 0 && !of_map.is_closed;
    const bool is_of_use = is_there && of_map.rest.has_value() && HasAllLater(of_map);
    if (is_of_use) first_error.Update(TellHeldBackOf(of_map, spool, told));
  }
  if (!told.empty()) first_error.Update(spool.Sync());
  for (const SpooledBatch& spooled : found) {
    if (IsHeldBack(spooled)) spool.Release(spooled);
  }
  std::erase_if(found, IsHeldBack);
  found.insert(found.end(), told.begin(), told.end());
  spool.SetFound(std::move(found));
  return first_error;
}

}  // namespace corbslam::client_agent
