// What the batches of a local map say it to be, so that a robot can go on with it after a restart.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_SPOOLED_MAP_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_SPOOLED_MAP_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/btree_set.h"
#include "absl/status/status.h"
#include "client_agent/upload/observation_mirror.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/point_followers.h"
#include "slam/map/map.h"
#include "slam/vocabulary/words.h"

namespace corbslam::client_agent {

// Takes batches in order, as the map store takes them. What it has then is what the store has of
// the local map's own items. Not thread-safe.
class SpooledMap {
 public:
  explicit SpooledMap(LocalMapId local_map) : local_map_(local_map) {}

  // Applies the next batch, or a part of a snapshot. Returns
  // INVALID_ARGUMENT, with the item and what is wrong with it, where the batch does not fit what
  // came before; what is here is of no use then.
  absl::Status Apply(const MapUpdateBatch& batch);
  // To be asked after the last batch. Returns INVALID_ARGUMENT where the map is not complete: it
  // has no keyframe, or its spanning tree is none.
  absl::Status Check() const;

  // Adds all to an empty map, but for what others made. `compute_words` is called for each
  // keyframe.
  using ComputeKeyframeWords =
      std::function<std::shared_ptr<const Words>(const std::vector<Descriptor>&)>;
  void Fill(const ComputeKeyframeWords& compute_words, Map& map) const;

  // Returns batches from which Apply makes the same again, each of so many keyframes or points at
  // most. They have no numbers.
  std::vector<MapUpdateBatch> ToBatches(size_t max_keyframes = 32, size_t max_points = 8000) const;

  LocalMapId local_map() const { return local_map_; }
  const std::map<KeyframeId, FullKeyframe>& keyframes() const { return keyframes_; }
  const std::map<MapPointId, FullMapPoint>& points() const { return points_; }
  // The observations, also of others' points.
  const ObservationMirror& observations() const { return observations_; }
  const std::vector<std::shared_ptr<const Camera>>& cameras() const { return cameras_; }
  const std::vector<std::optional<RecordedCamera>>& recorded_cameras() const { return recorded_; }
  // Indices greater than all that were ever named.
  uint32_t next_keyframe() const { return next_keyframe_; }
  uint32_t next_point() const { return next_point_; }
  // The latest time of a frame or keyframe; nullopt: there was none.
  std::optional<int64_t> newest_ns() const { return newest_ns_; }

 private:
  absl::Status AddCameras(const MapUpdateBatch& batch);
  absl::Status AddKeyframe(FullKeyframe keyframe);
  absl::Status AddPoint(const FullMapPoint& point);
  absl::Status MoveKeyframe(const LightKeyframe& light, bool points_follow);
  absl::Status MovePoint(const LightMapPoint& light);
  absl::Status Replace(const PointReplacement& replacement);
  absl::Status Observe(const ObservationChange& change);
  void Remove(const KeyframeRemoval& removal);
  void NoteFrames(const MapUpdateBatch& batch);
  void NoteTime(int64_t timestamp_ns);
  void NoteIndex(KeyframeId id);
  void NoteIndex(MapPointId id);
  void AppendNames(MapUpdateBatch& batch) const;

  const LocalMapId local_map_;
  std::vector<std::shared_ptr<const Camera>> cameras_;
  std::vector<std::optional<RecordedCamera>> recorded_;
  std::map<KeyframeId, FullKeyframe> keyframes_;
  // Points that were told may have references that were taken out since.
  std::map<MapPointId, FullMapPoint> points_;
  PointFollowers followers_;
  ObservationMirror observations_;
  // Only those between keyframes of the map's own.
  absl::btree_set<std::pair<KeyframeId, KeyframeId>> loop_edges_;
  uint32_t next_keyframe_ = 0;
  uint32_t next_point_ = 0;
  std::optional<int64_t> newest_ns_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_SPOOLED_MAP_H_
