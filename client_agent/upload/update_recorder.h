// Hears the changes of the robot's map and turns them, aggregated, into batches for the map store.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_UPDATE_RECORDER_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_UPDATE_RECORDER_H_

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/btree_set.h"
#include "absl/container/flat_hash_map.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/map/provisional_keyframes.h"
#include "client_agent/upload/batch_allowance.h"
#include "client_agent/upload/believed_places.h"
#include "client_agent/upload/feature_selection.h"
#include "client_agent/upload/held_back.h"
#include "client_agent/upload/held_back_items.h"
#include "client_agent/upload/item_gate.h"
#include "client_agent/upload/observation_mirror.h"
#include "client_agent/upload/spooled_map.h"
#include "slam/exchange/map_update.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// Items of one batch, beside full keyframes; what is over goes into the next one. Together they are
// below the 65,000 items and 200,000 frames, and a quarter of the 500,000 steps, beyond which a
// store refuses a batch, and would do so for ever (docs/adr/0024-what-a-batch-costs.md).
struct BatchLimits {
  size_t full_points = 8000;
  size_t light_keyframes = 8000;
  size_t light_points = 10000;
  size_t replacements = 4000;
  size_t observations = 20000;
  size_t removed_points = 8000;
  size_t removed_keyframes = 500;
  size_t loop_edges = 2000;
  // Tracked ones, and as many lost ones.
  size_t frames = 30000;
  // Pairs of keyframes of which the number of points that both see changes, by replacements,
  // observations and removals together, beside those of the last item.
  uint64_t pairs = 125000;
};

struct RecorderOptions {
  // What recorded the pictures of the map's cameras; nullopt: not said.
  std::optional<RecordedCamera> recorded_camera = std::nullopt;
  FeatureSelection features = {};
  // The newest so many keyframes are held back, what hangs on them with them: mapping may yet take
  // them out, and judges only after it has mapped the one that makes the oldest of them old enough.
  // Never the first, and none for longer than `hold_at_most_ns` by the frames' own times.
  size_t hold_newest = kProvisionalKeyframes + 1;
  int64_t hold_at_most_ns = 3'000'000'000;
  // Points that were told are told anew once in so long, by the frames' own times: each adjustment
  // of the robot's moves them again. 0, or hold_newest 0: with each batch.
  int64_t light_points_every_ns = 2'000'000'000;
  BatchLimits limits = {};
};

// Records one local map. Only that map's own items are recorded: what others made is theirs to
// tell. Changes of one item between two batches coalesce to its state when the batch is made; a
// point that the store sees where it is, as far as half a pixel tells, isn't told again. Nothing is
// dropped while no batch is taken, and what waits is bounded by the map's size and the number of
// frames. Thread-safe.
class UpdateRecorder : public MapObserver {
 public:
  explicit UpdateRecorder(LocalMapId local_map, const RecorderOptions& options = {})
      : local_map_(local_map), options_(options) {}

  void OnKeyframeAdded(KeyframeId id) override;
  void OnKeyframeMoved(KeyframeId id) override;
  void OnParentChanged(KeyframeId id) override;
  void OnLoopEdgeAdded(KeyframeId a, KeyframeId b) override;
  void OnKeyframeRemoved(KeyframeId id, KeyframeId parent,
                         const Rigid3d& parent_from_removed) override;
  void OnPointAdded(MapPointId id) override;
  void OnPointMoved(MapPointId id) override;
  void OnObservationAdded(MapPointId point, KeyframeId keyframe, uint32_t keypoint) override;
  void OnObservationRemoved(MapPointId point, KeyframeId keyframe, uint32_t keypoint) override;
  void OnPointReplaced(MapPointId replaced, MapPointId survivor) override;
  void OnPointRemoved(MapPointId id) override;
  bool MayChangeKeypoints(KeyframeId id) const override;

  // Whether the store moves points with their keyframes, as every batch says it shall. Where it
  // turns out not to, all points are told again: it left them where it had them.
  void SetPointsFollow(bool points_follow);

  void AddTrackedFrame(const TrackedFrame& frame);
  void AddLostFrame(int64_t timestamp_ns);

  // From now on, until all is told, nothing is held back, and the places of points are told exactly
  // and not only where they would look different by half a pixel.
  void AskForExactPlaces();
  // Nothing is held back until the next frame comes.
  void StopHoldingBack();
  // Holds back again.
  void HoldBack() ABSL_LOCKS_EXCLUDED(mutex_);

  LocalMapId local_map() const { return local_map_; }
  bool HasChanges() const;
  // Items that were not told because their values are impossible (slam/exchange/item_checks.h),
  // since the beginning; each is logged. What hangs on such an item is not told either.
  uint64_t refused_items() const;
  // About how many keyframes a batch is yet to carry that are not held back.
  size_t pending_keyframes() const;
  // What no batch has carried yet.
  UpdateCounts CountUntold() const;

  // The changes since the last call, as a batch without a number, as far as `allowance` goes (the
  // rest, and what hangs on it, waits for the next call): all poses, at least one full keyframe,
  // and points once no full keyframe waits, each as far as BatchLimits go. Never empty where
  // something can be told. `map` is the observed one; the caller keeps it from changing.
  MapUpdateBatch TakeBatch(const Map& map, BatchAllowance allowance);
  // The same, with at most `max_keyframes` full keyframes.
  MapUpdateBatch TakeBatch(const Map& map, size_t max_keyframes) {
    return TakeBatch(map, BatchAllowance(max_keyframes));
  }

  // Goes on where an earlier process ended: the store has been told `spooled_map`, and no
  // more. To be called before anything else.
  void GoOnFrom(const SpooledMap& spooled_map);

  // Copies what is new and in no batch yet, for a disk that is to outlive the process
  // (held_back_items.h). A keyframe's payload is in it the first time only.
  HeldBackItems CopyHeldBack(const Map& map);
  // The copies are of no use any more: the next one has every payload.
  void CopyHeldBackAnew();
  // Counts what changes in it: where it is as before, there is nothing to copy.
  uint64_t held_back_changes() const;

 private:
  bool IsOwn(KeyframeId id) const { return id.local_map == local_map_; }
  bool IsOwn(MapPointId id) const { return id.local_map == local_map_; }
  bool HasMore() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Whether the batch that is being made changes as many pairs as one may.
  bool IsOutOfPairs() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return mirror_.pairs() - pairs_before_ >= options_.limits.pairs;
  }
  MapPointId ResolveSurvivor(const Map& map, MapPointId replaced) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // What is held back from here on; invalid: nothing.
  KeyframeId FirstHeldBack(const Map& map) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsOverdue(const Map& map, KeyframeId id) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeCameras(const FullKeyframe& keyframe, MapUpdateBatch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The poses that go up now.
  void SpendPoses(const Map& map, BatchAllowance& allowance) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeFullKeyframes(const Map& map, BatchAllowance& allowance, MapUpdateBatch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeFullPoints(const Map& map, BatchAllowance& allowance, MapUpdateBatch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteParent(const Keyframe& keyframe, KeyframeId told) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeLightKeyframes(const Map& map, MapUpdateBatch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeLightPoints(const Map& map, BatchAllowance& allowance, MapUpdateBatch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool AreLightPointsDue() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsToldWell(const Map& map, const MapPoint& point) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteWithdrawn(const Map& map, const std::map<KeyframeId, uint32_t>& replaced,
                     MapPointId survivor) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeReplacements(const Map& map, MapUpdateBatch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeObservations(const Map& map, MapUpdateBatch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeRemovals(MapUpdateBatch& batch) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeLoopEdges(const Map& map, MapUpdateBatch& batch) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeFrames(MapUpdateBatch& batch) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  KeyframeId KnownAncestor(const Map& map, KeyframeId id) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  KeyframeId KnownReference(const MapPoint& point) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The keypoint's number at the store, or kLeftOut.
  uint32_t NumberAtStore(KeyframeId id, uint32_t keypoint) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsSeenAtStore(const MapPoint& point) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool MayBeSeenLater(const Map& map, const MapPoint& point) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CopyHeldBackKeyframes(const Map& map, HeldBackItems& held_back)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CopyHeldBackPoints(const Map& map, MapUpdateBatch& rest) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CopyHeldBackObservations(const Map& map, MapUpdateBatch& rest) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CopyHeldBackFrames(MapUpdateBatch& rest) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsToldOrHeldBack(KeyframeId id) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return sent_keyframes_.contains(id) || held_back_numbers_.contains(id);
  }
  // Returns the point as a batch has it, with a reference that the store knows then.
  static FullMapPoint DescribePoint(const MapPoint& point, KeyframeId reference);
  // The keypoint's number at the store, or what it will be; or kLeftOut.
  uint32_t NumberOf(KeyframeId id, uint32_t keypoint) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const LocalMapId local_map_;
  const RecorderOptions options_;

  mutable absl::Mutex mutex_;
  ItemGate gate_ ABSL_GUARDED_BY(mutex_);
  // Full keyframes that were not let through: nothing that names them goes up.
  absl::btree_set<KeyframeId> refused_keyframes_ ABSL_GUARDED_BY(mutex_);
  // What the store has been told.
  absl::btree_set<KeyframeId> sent_keyframes_ ABSL_GUARDED_BY(mutex_);
  absl::btree_set<MapPointId> sent_points_ ABSL_GUARDED_BY(mutex_);
  // Which ancestors keyframes were told to hang on whose parents the store hasn't been told of.
  absl::btree_map<KeyframeId, KeyframeId> stand_ins_ ABSL_GUARDED_BY(mutex_);
  // SelectedFeatures::numbers of each keyframe of which features were left out.
  absl::flat_hash_map<KeyframeId, std::vector<uint32_t>> numbers_ ABSL_GUARDED_BY(mutex_);
  uint32_t sent_cameras_ ABSL_GUARDED_BY(mutex_) = 0;
  ObservationMirror mirror_ ABSL_GUARDED_BY(mutex_);
  uint64_t pairs_before_ ABSL_GUARDED_BY(mutex_) = 0;  // Of `mirror_`, when the batch was begun.
  BelievedPlaces believed_ ABSL_GUARDED_BY(mutex_);
  // What it has not been told.
  absl::btree_set<KeyframeId> added_keyframes_ ABSL_GUARDED_BY(mutex_);
  absl::btree_set<KeyframeId> changed_keyframes_ ABSL_GUARDED_BY(mutex_);
  absl::btree_set<KeyframeId> reobserved_keyframes_ ABSL_GUARDED_BY(mutex_);
  // Keypoints from which others' points were taken, told apart from points that were only unloaded.
  absl::btree_map<std::pair<KeyframeId, uint32_t>, MapPointId> withdrawn_ ABSL_GUARDED_BY(mutex_);
  absl::btree_set<MapPointId> added_points_ ABSL_GUARDED_BY(mutex_);
  // Points that moved here, or whose reference keyframe moved at the store.
  absl::btree_set<MapPointId> moved_points_ ABSL_GUARDED_BY(mutex_);
  bool exactly_ ABSL_GUARDED_BY(mutex_) = false;
  bool holds_back_ ABSL_GUARDED_BY(mutex_) = true;
  int64_t newest_frame_ns_ ABSL_GUARDED_BY(mutex_) = 0;
  // The newest frame's when all points that had moved were told; nullopt: never.
  std::optional<int64_t> points_told_ns_ ABSL_GUARDED_BY(mutex_);
  bool points_follow_ ABSL_GUARDED_BY(mutex_) = true;
  absl::btree_map<MapPointId, MapPointId> replaced_points_ ABSL_GUARDED_BY(mutex_);
  absl::btree_set<MapPointId> removed_points_ ABSL_GUARDED_BY(mutex_);
  std::vector<KeyframeRemoval> removed_keyframes_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::pair<KeyframeId, KeyframeId>> loop_edges_ ABSL_GUARDED_BY(mutex_);
  std::vector<TrackedFrame> tracked_frames_ ABSL_GUARDED_BY(mutex_);
  std::vector<int64_t> lost_frames_ns_ ABSL_GUARDED_BY(mutex_);
  // Keyframes whose payload CopyHeldBack has given, and SelectedFeatures::numbers of them.
  absl::btree_map<KeyframeId, std::vector<uint32_t>> held_back_numbers_ ABSL_GUARDED_BY(mutex_);
  uint64_t held_back_changes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_UPDATE_RECORDER_H_
