// A batch that a store takes in, with hardly anything in it.
#ifndef CORBSLAM_MAP_STORE_TESTING_BLANK_BATCH_H_
#define CORBSLAM_MAP_STORE_TESTING_BLANK_BATCH_H_

#include <cstddef>
#include <cstdint>
#include <memory>

#include "slam/exchange/map_update.h"

namespace corbslam::testing {

// Returns a batch with one keyframe, whose index is `number`; the first one has the camera.
inline MapUpdateBatch BlankBatch(LocalMapId local_map, uint64_t number, size_t keypoints = 0) {
  MapUpdateBatch batch;
  batch.local_map = local_map;
  batch.number = number;
  if (number == 1) {
    batch.cameras = {std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})};
  }
  auto payload = std::make_shared<KeyframePayload>();
  payload->id = {local_map, static_cast<uint32_t>(number)};
  payload->features.keypoints.resize(keypoints);
  payload->features.descriptors.resize(keypoints);
  batch.full_keyframes = {{payload, Rigid3d::Identity(), {}}};
  return batch;
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_BLANK_BATCH_H_
