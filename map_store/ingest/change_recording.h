// Notes in the local maps' change logs what a batch or a revision does to them.
#ifndef CORBSLAM_MAP_STORE_INGEST_CHANGE_RECORDING_H_
#define CORBSLAM_MAP_STORE_INGEST_CHANGE_RECORDING_H_

#include "absl/container/flat_hash_set.h"
#include "map_store/state/mission_state.h"
#include "slam/map/map_observer.h"

namespace corbslam::map_store {

// Notes, as long as it lives, all changes of a local map's own graph but those of points that go,
// for which there is NoteLandmarkChanges. Not thread-safe.
class ChangeRecorder : private MapObserver {
 public:
  explicit ChangeRecorder(LocalMapState& local_map) : local_map_(local_map) {
    local_map_.map.SetObserver(this);
  }
  ~ChangeRecorder() override { local_map_.map.SetObserver(nullptr); }
  ChangeRecorder(const ChangeRecorder&) = delete;
  ChangeRecorder& operator=(const ChangeRecorder&) = delete;

 private:
  void OnKeyframeAdded(KeyframeId id) override { log().NoteKeyframe(id); }
  void OnKeyframeMoved(KeyframeId id) override { log().NoteKeyframe(id); }
  void OnParentChanged(KeyframeId id) override { log().NoteKeyframe(id); }
  void OnKeyframeRemoved(KeyframeId id, KeyframeId, const Rigid3d&) override {
    log().NoteKeyframe(id);
  }
  void OnPointMoved(MapPointId id) override { log().NotePoint(id); }
  void OnObservationAdded(MapPointId, KeyframeId id, uint32_t) override { log().NoteSights(id); }
  void OnObservationRemoved(MapPointId, KeyframeId id, uint32_t) override { log().NoteSights(id); }

  ChangeLog& log() { return local_map_.changes; }

  LocalMapState& local_map_;
};

// Notes points whose landmarks are about to change, and the keyframes, of whatever local map, that
// see one of those landmarks.
void NoteLandmarkChanges(const absl::flat_hash_set<MapPointId>& points, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_CHANGE_RECORDING_H_
