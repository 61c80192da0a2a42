// A robot for tests of the store: it streams a synthetic local map, keyframe by keyframe.
#ifndef CORBSLAM_MAP_STORE_TESTING_TEST_AGENT_H_
#define CORBSLAM_MAP_STORE_TESTING_TEST_AGENT_H_

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "map_store/store/map_store.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::testing {

// Returns a small vocabulary of the world's own descriptors.
std::shared_ptr<const Vocabulary> MakeTestVocabulary(const SyntheticWorld& world);

// What an agent holds of the global layer after applying its updates.
struct SharedMirror {
  std::map<KeyframeId, SharedKeyframe> keyframes;
  std::map<MapPointId, SharedMapPoint> points;
  std::map<KeyframeId, Similarity3d> own;
  std::map<MapPointId, std::vector<MapPointId>> landmarks;
  std::optional<Similarity3d> global_from_local;
  bool apart = false;
  int restarts = 0;
  int updates = 0;
  uint64_t revision = 0;

  void Apply(const SharedUpdate& update);
};

// An agent and its session. Not thread-safe.
class TestAgent {
 public:
  // Opens the agent's session. `store` and `made` must outlive it.
  TestAgent(map_store::MapStore& store, std::string mission, std::string name,
            const SyntheticMap& made);

  // Opens another session, which goes on from what `mirror` holds and wants to be told `scope`.
  absl::Status Resume(const ShareScope& scope);

  // Returns the next numbered batch, of `keyframes` keyframes with their points and a tracked frame
  // each.
  MapUpdateBatch NextBatch(size_t keyframes);
  // Returns an empty batch with the next number.
  MapUpdateBatch EmptyBatch();
  absl::Status Send(const MapUpdateBatch& batch);
  // Sends the next keyframes in a batch each; all that are left by default.
  absl::Status Stream(size_t keyframes = 1000000);
  absl::Status Close();
  // Takes updates until there are no more, and applies them to `mirror`.
  absl::Status TakeShared(size_t byte_budget = 1 << 20);

  const std::string& name() const { return name_; }

  uint64_t session() const { return session_; }
  LocalMapId local_map() const { return local_map_; }
  KeyframeId Id(uint32_t index) const { return {local_map_, index}; }
  const SharedMirror& mirror() const { return mirror_; }
  const SyntheticMap& made() const { return made_; }

 private:
  void AddPoints(const Keyframe& keyframe, MapUpdateBatch& batch);

  map_store::MapStore& store_;
  const std::string mission_;
  const std::string name_;
  const SyntheticMap& made_;
  const LocalMapId local_map_;
  uint64_t session_ = 0;
  uint64_t next_number_ = 1;
  uint32_t next_keyframe_ = 0;
  SharedMirror mirror_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_TEST_AGENT_H_
