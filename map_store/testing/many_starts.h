// A mission of one robot that started many times at one place, as fusion left it.
#ifndef CORBSLAM_MAP_STORE_TESTING_MANY_STARTS_H_
#define CORBSLAM_MAP_STORE_TESTING_MANY_STARTS_H_

#include <cstdint>
#include <memory>
#include <utility>

#include "map_store/state/mission_state.h"

namespace corbslam::testing {

inline constexpr char kManyStartsAgent[] = "r";
inline constexpr uint32_t kKeyframesOfStart = 3;

// Returns where a session's frame lies in the island's.
inline Similarity3d IslandFromStart(uint64_t session) {
  const double turn = 0.1 * static_cast<double>(session);
  return {1,
          Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY())),
          {0.01 * static_cast<double>(session), 0.02, -0.3 * turn}};
}

// Adds a closed local map of three keyframes, each with a point; the last one is not placed. Where
// `joined` it lies in the first one's island.
inline void AddStart(uint64_t session, bool joined, map_store::MissionState& state) {
  using map_store::LocalMapState;
  const LocalMapId id{session};
  LocalMapState& local_map = map_store::AddLocalMap(state, id, kManyStartsAgent);
  local_map.closed = true;
  local_map.last_batch = 10 + session;
  local_map.cameras = {
      std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})};
  local_map.recorded_cameras.resize(1);
  const Similarity3d start_from_island = IslandFromStart(session).Inverse();
  for (uint32_t i = 0; i < kKeyframesOfStart; ++i) {
    Features features;
    features.keypoints.resize(4);
    features.descriptors.resize(4);
    Keyframe keyframe;
    keyframe.payload =
        MakeKeyframePayload({id, i}, 1000 + i, 0, local_map.cameras[0], std::move(features));
    keyframe.points.resize(4);
    keyframe.camera_from_map = {Eigen::Quaterniond::Identity(), {-1.0 * i, 0.1, 0}};
    if (i > 0) keyframe.parent = {id, i - 1};
    const Rigid3d pose = keyframe.camera_from_map;
    local_map.map.AddKeyframe(std::move(keyframe));
    local_map.arrival[{id, i}] = i;
    local_map.arrived.push_back({id, i});
    local_map.frames.push_back({1000 + i, {id, i}, {}});
    MapPoint point;
    point.id = {id, i};
    point.position_in_map = {1.0 * i, 0, 5};
    point.reference = {id, i};
    point.normal_in_map = Eigen::Vector3d::UnitZ();
    point.max_distance = 10;
    local_map.map.AddPoint(point);
    local_map.map.AddObservation({id, i}, {id, i}, i);
    local_map.followers.Add({id, i}, {id, i});
    if (i + 1 == kKeyframesOfStart) continue;
    state.global.keyframes[{id, i}] = {Similarity3d::FromRigid(pose) * start_from_island, pose, 1};
  }
  local_map.settled = local_map.arrived.size();
  state.global.island_from_local[id] = IslandFromStart(session);
  if (!joined || session == 1) return;
  state.global.islands.erase(id);
  state.global.islands.at(LocalMapId{1}).local_maps.push_back(id);
  map_store::SetIslandOf(local_map, LocalMapId{1}, state);
}

inline map_store::MissionState MakeManyStarts(uint64_t sessions) {
  map_store::MissionState state;
  state.name = "m";
  for (uint64_t session = 1; session <= sessions; ++session) AddStart(session, true, state);
  state.global.islands.at(LocalMapId{1}).fused = true;
  map_store::IndexPoints(state);
  return state;
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_MANY_STARTS_H_
