// Makes missions that take as much room as real ones, for tests of the journal's disk.
#ifndef CORBSLAM_MAP_STORE_TESTING_FEATURE_MISSION_H_
#define CORBSLAM_MAP_STORE_TESTING_FEATURE_MISSION_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "map_store/state/mission_state.h"

namespace corbslam::testing {

// Returns a mission of many keyframes with features that no coding makes shorter, about 45 bytes
// each, and nothing else.
inline map_store::MissionState MakeFeatureMission(const std::string& name, uint32_t keyframes,
                                                  size_t features) {
  map_store::MissionState state;
  state.name = name;
  map_store::LocalMapState& local_map = map_store::AddLocalMap(state, LocalMapId{1}, "a");
  state.agents["a"].local_maps = {local_map.id};
  const auto camera = std::make_shared<const Camera>(Camera{
      .fx_px = 500, .fy_px = 500, .cx_px = 320, .cy_px = 240, .width_px = 640, .height_px = 480});
  local_map.cameras = {camera};
  local_map.recorded_cameras.resize(1);
  std::mt19937 random(1);
  for (uint32_t i = 0; i < keyframes; ++i) {
    auto payload = std::make_shared<KeyframePayload>();
    payload->id = {local_map.id, i};
    payload->camera = camera;
    payload->features.keypoints.resize(features);
    payload->features.descriptors.resize(features);
    for (Keypoint& keypoint : payload->features.keypoints) {
      keypoint.x_px = static_cast<float>(random() % 640000) / 1000;
      keypoint.y_px = static_cast<float>(random() % 480000) / 1000;
    }
    for (Descriptor& descriptor : payload->features.descriptors) {
      for (uint64_t& word : descriptor.words) word = (uint64_t{random()} << 32) | random();
    }
    Keyframe keyframe;
    keyframe.payload = std::move(payload);
    keyframe.points.resize(features);
    if (i > 0) keyframe.parent = {local_map.id, i - 1};
    local_map.arrival[keyframe.payload->id] = i;
    local_map.arrived.push_back(keyframe.payload->id);
    local_map.map.AddKeyframe(std::move(keyframe));
  }
  return state;
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_FEATURE_MISSION_H_
