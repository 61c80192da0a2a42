// Makes up items for the tests of services.
#ifndef CORBSLAM_SERVICES_CONVERT_TESTING_TEST_DATA_H_
#define CORBSLAM_SERVICES_CONVERT_TESTING_TEST_DATA_H_

#include <cstdint>
#include <memory>
#include <random>

#include "slam/exchange/fusion_worker.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/shared_update.h"
#include "slam/map/map.h"

namespace corbslam::test_data {

inline constexpr LocalMapId kMap{0xc0ffee00c0ffee01};
inline constexpr LocalMapId kOtherMap{0x0000000000000002};

std::shared_ptr<const Camera> MakeCamera();
Rigid3d MakeMotion(std::mt19937& random);
Similarity3d MakeSimilarity(std::mt19937& random);
// Makes features on the wire's grid of positions, disparities and angles.
Features MakeFeatures(std::mt19937& random, int count);
std::shared_ptr<const KeyframePayload> MakePayload(std::mt19937& random, KeyframeId id, int count);
// Makes a batch with something in every field; positions are floats.
MapUpdateBatch MakeBatch(std::mt19937& random, LocalMapId local_map, uint64_t number,
                         int keyframes = 2, int features = 30);
SharedUpdate MakeSharedUpdate(std::mt19937& random);
// Makes keyframes in a row with points, words, a spanning tree and a loop edge.
Map MakeMap(std::mt19937& random, LocalMapId local_map, int keyframes);
Overlap MakeOverlap(std::mt19937& random, KeyframeId query, KeyframeId candidate);

}  // namespace corbslam::test_data

#endif  // CORBSLAM_SERVICES_CONVERT_TESTING_TEST_DATA_H_
