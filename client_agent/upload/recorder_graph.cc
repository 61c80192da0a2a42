// Takes replacements, observations, removals, loop edges and frames into a batch.
#include <utility>

#include "client_agent/upload/update_recorder.h"
#include "slam/exchange/item_checks.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

absl::Status ValidateFrame(const TrackedFrame& frame) {
  RETURN_IF_ERROR(ValidateTime("tracked frame", frame.timestamp_ns));
  return ValidatePose("tracked frame of", frame.reference, "reference_from_camera",
                      frame.reference_from_camera);
}

}  // namespace

MapPointId UpdateRecorder::ResolveSurvivor(const Map& map, MapPointId replaced) const {
  MapPointId survivor = replaced;
  for (auto it = replaced_points_.find(survivor); it != replaced_points_.end();
       it = replaced_points_.find(survivor)) {
    survivor = it->second;
  }
  return map.FindPoint(survivor) == nullptr ? MapPointId() : survivor;
}

// Keypoints that the store takes to see the survivor since it stands for the replaced point, but
// that don't: where they saw it already with another one, or do no more.
void UpdateRecorder::NoteWithdrawn(const Map& map, const std::map<KeyframeId, uint32_t>& replaced,
                                   MapPointId survivor) {
  const MapPoint& point = *map.FindPoint(survivor);
  for (const auto& [id, keypoint] : replaced) {
    if (!point.observations.contains(id)) withdrawn_[{id, keypoint}] = survivor;
  }
}

void UpdateRecorder::TakeReplacements(const Map& map, MapUpdateBatch& batch) {
  absl::btree_map<MapPointId, MapPointId> waiting;
  for (const auto& [replaced, last_survivor] : replaced_points_) {
    if (!sent_points_.contains(replaced)) continue;
    const MapPointId survivor = ResolveSurvivor(map, replaced);
    if (!survivor.IsValid()) {
      removed_points_.insert(replaced);
      continue;
    }
    if (IsOwn(survivor) && !sent_points_.contains(survivor)) {
      // Seen by nobody any more it is not told, and what it replaced is not there either.
      if (added_points_.contains(survivor)) {
        waiting.emplace(replaced, survivor);
      } else {
        removed_points_.insert(replaced);
      }
      continue;
    }
    if (batch.replacements.size() == options_.limits.replacements || IsOutOfPairs()) {
      waiting.emplace(replaced, survivor);
      continue;
    }
    const std::map<KeyframeId, uint32_t> observations = mirror_.Observations(replaced);
    for (const auto& [id, keypoint] : observations) reobserved_keyframes_.insert(id);
    mirror_.ReplacePoint(replaced, survivor);
    if (!IsOwn(survivor)) NoteWithdrawn(map, observations, survivor);
    sent_points_.erase(replaced);
    believed_.RemovePoint(replaced);
    batch.replacements.push_back({replaced, survivor});
  }
  for (const auto& [replaced, last_survivor] : replaced_points_) {
    const MapPoint* survivor = map.FindPoint(ResolveSurvivor(map, replaced));
    if (survivor == nullptr) continue;
    for (const auto& [id, keypoint] : survivor->observations) {
      if (IsOwn(id)) reobserved_keyframes_.insert(id);
    }
  }
  replaced_points_ = std::move(waiting);
}

void UpdateRecorder::TakeObservations(const Map& map, MapUpdateBatch& batch) {
  absl::btree_set<KeyframeId> waiting;
  const auto can_tell = [this](MapPointId id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return !IsOwn(id) || sent_points_.contains(id);
  };
  const auto has_room = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return batch.observations.size() < options_.limits.observations && !IsOutOfPairs();
  };
  for (const KeyframeId& id : reobserved_keyframes_) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr || refused_keyframes_.contains(id)) continue;
    if (!has_room()) {
      waiting.insert(id);
      continue;
    }
    const auto is_withdrawn = [&](uint32_t keypoint) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return withdrawn_.contains({id, keypoint});
    };
    const auto is_sent = [&](uint32_t keypoint) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return NumberAtStore(id, keypoint) != kLeftOut;
    };
    if (!sent_keyframes_.contains(id) ||
        !mirror_.AppendChanges(*keyframe, {can_tell, is_withdrawn, is_sent, has_room},
                               batch.observations)) {
      waiting.insert(id);
    }
  }
  for (ObservationChange& change : batch.observations) {
    change.keypoint = NumberAtStore(change.keyframe, change.keypoint);
  }
  absl::erase_if(withdrawn_, [&waiting](const auto& withdrawn) {
    return !waiting.contains(withdrawn.first.first);
  });
  reobserved_keyframes_ = std::move(waiting);
}

void UpdateRecorder::TakeRemovals(MapUpdateBatch& batch) {
  while (!removed_points_.empty() && !IsOutOfPairs() &&
         batch.removed_points.size() < options_.limits.removed_points) {
    const MapPointId id = *removed_points_.begin();
    removed_points_.erase(removed_points_.begin());
    if (sent_points_.erase(id) == 0) continue;
    mirror_.RemovePoint(id);
    believed_.RemovePoint(id);
    batch.removed_points.push_back(id);
  }
  // A keyframe goes after its children hang on others.
  if (!changed_keyframes_.empty()) return;
  auto removal = removed_keyframes_.begin();
  for (; removal != removed_keyframes_.end() &&
         batch.removed_keyframes.size() < options_.limits.removed_keyframes && !IsOutOfPairs();
       ++removal) {
    sent_keyframes_.erase(removal->id);
    numbers_.erase(removal->id);
    stand_ins_.erase(removal->id);
    mirror_.RemoveKeyframe(removal->id);
    believed_.RemoveKeyframe(removal->id);
    // Frames that name it may still come.
    if (refused_keyframes_.contains(removal->id)) continue;
    if (gate_.Admit(ValidateRemoval(*removal))) batch.removed_keyframes.push_back(*removal);
  }
  removed_keyframes_.erase(removed_keyframes_.begin(), removal);
}

void UpdateRecorder::TakeLoopEdges(const Map& map, MapUpdateBatch& batch) {
  std::vector<std::pair<KeyframeId, KeyframeId>> waiting;
  for (const auto& [a_id, b_id] : loop_edges_) {
    const Keyframe* a = map.FindKeyframe(a_id);
    const Keyframe* b = map.FindKeyframe(b_id);
    if (a == nullptr || b == nullptr) continue;
    if (refused_keyframes_.contains(a_id) || refused_keyframes_.contains(b_id)) continue;
    if (batch.loop_edges.size() == options_.limits.loop_edges || !sent_keyframes_.contains(a_id) ||
        (IsOwn(b_id) && !sent_keyframes_.contains(b_id))) {
      waiting.emplace_back(a_id, b_id);
      continue;
    }
    const Rigid3d b_from_a = b->camera_from_map * a->camera_from_map.Inverse();
    const Similarity3d similarity = Similarity3d::FromRigid(b_from_a);
    if (!gate_.Admit(ValidateSimilarity("loop edge from", a_id, similarity))) continue;
    batch.loop_edges.push_back({a_id, b_id, similarity});
  }
  loop_edges_ = std::move(waiting);
}

// A frame goes up with or after its reference keyframe.
void UpdateRecorder::TakeFrames(MapUpdateBatch& batch) {
  std::vector<TrackedFrame> waiting;
  for (const TrackedFrame& frame : tracked_frames_) {
    // Where its keyframe was not told, nobody can tell where it was.
    if (refused_keyframes_.contains(frame.reference)) continue;
    const bool waits = added_keyframes_.contains(frame.reference) ||
                       batch.tracked_frames.size() == options_.limits.frames;
    if (!waits && !gate_.Admit(ValidateFrame(frame))) continue;
    (waits ? waiting : batch.tracked_frames).push_back(frame);
  }
  tracked_frames_ = std::move(waiting);
  auto lost = lost_frames_ns_.begin();
  for (; lost != lost_frames_ns_.end() && batch.lost_frames_ns.size() < options_.limits.frames;
       ++lost) {
    if (gate_.Admit(ValidateTime("lost frame", *lost))) batch.lost_frames_ns.push_back(*lost);
  }
  lost_frames_ns_.erase(lost_frames_ns_.begin(), lost);
}

}  // namespace corbslam::client_agent
