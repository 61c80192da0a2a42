#include "services/convert/testing/test_data.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace corbslam::test_data {
namespace {

double Uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
float OnGrid(std::mt19937& random, double low, double high, double steps) {
  return static_cast<float>(std::round(Uniform(random, low, high) * steps) / steps);
}
Eigen::Vector3d MakePosition(std::mt19937& random) {
  Eigen::Vector3d position;
  for (double& value : position) value = OnGrid(random, -100, 100, 1024);
  return position;
}
Descriptor MakeDescriptor(std::mt19937& random) {
  std::mt19937_64 bits(random());
  return {{bits(), bits(), bits(), bits()}};
}

template <typename Point>
Point MakePoint(std::mt19937& random, MapPointId id, KeyframeId reference) {
  Point point;
  point.id = id;
  point.reference = reference;
  point.descriptor = MakeDescriptor(random);
  point.min_distance = OnGrid(random, 0, 10, 64);
  point.max_distance = point.min_distance + 5;
  return point;
}

}  // namespace

std::shared_ptr<const Camera> MakeCamera() {
  return std::make_shared<const Camera>(Camera{.fx_px = 718.856,
                                               .fy_px = 718.856,
                                               .cx_px = 607.1928,
                                               .cy_px = 185.2157,
                                               .width_px = 1241,
                                               .height_px = 376,
                                               .baseline_m = 0.537,
                                               .close_depth_m = 21});
}

Rigid3d MakeMotion(std::mt19937& random) {
  const Eigen::Quaterniond rotation(Uniform(random, -1, 1), Uniform(random, -1, 1),
                                    Uniform(random, -1, 1), 0.5);
  return {rotation.normalized(), MakePosition(random)};
}

Similarity3d MakeSimilarity(std::mt19937& random) {
  Similarity3d similarity = Similarity3d::FromRigid(MakeMotion(random));
  similarity.scale = Uniform(random, 0.5, 2);
  return similarity;
}

Features MakeFeatures(std::mt19937& random, int count) {
  Features features;
  for (int i = 0; i < count; ++i) {
    Keypoint keypoint;
    keypoint.x_px = OnGrid(random, 0, 1240, 64);
    keypoint.y_px = OnGrid(random, 0, 375, 64);
    keypoint.disparity_px = i % 3 == 0 ? 0.f : OnGrid(random, 1, 60, 128);
    const double turn = std::round(Uniform(random, -8191, 8192));
    keypoint.angle_rad = static_cast<float>(turn / (16384 / (2 * std::numbers::pi)));
    keypoint.octave = static_cast<uint8_t>(i % 8);
    features.keypoints.push_back(keypoint);
    features.descriptors.push_back(MakeDescriptor(random));
  }
  return features;
}

std::shared_ptr<const KeyframePayload> MakePayload(std::mt19937& random, KeyframeId id, int count) {
  return MakeKeyframePayload(id, 1'000'000'000'000 + id.index * 100'000'000LL, 0, MakeCamera(),
                             MakeFeatures(random, count));
}

MapUpdateBatch MakeBatch(std::mt19937& random, LocalMapId local_map, uint64_t number, int keyframes,
                         int features) {
  MapUpdateBatch batch;
  batch.local_map = local_map;
  batch.number = number;
  if (number == 1) batch.cameras = {MakeCamera()};
  // Each batch has numbers of its own, ten keyframes and a hundred points apart.
  const auto first = static_cast<uint32_t>(number) * 10;
  const auto point = [&](uint32_t i) { return MapPointId{local_map, first * 10 + i}; };
  const KeyframeId reference{local_map, first};
  for (uint32_t i = 0; i < static_cast<uint32_t>(keyframes); ++i) {
    const KeyframeId id{local_map, first + i};
    const KeyframeId parent = i == 0 ? KeyframeId() : reference;
    batch.full_keyframes.push_back({MakePayload(random, id, features), MakeMotion(random), parent});
  }
  batch.light_keyframes.push_back({reference, MakeMotion(random), KeyframeId()});
  for (uint32_t i = 0; i < 20; ++i) {
    auto full = MakePoint<FullMapPoint>(random, point(i), reference);
    full.position_in_local = MakePosition(random);
    full.normal_in_local = MakePosition(random).normalized();
    batch.full_points.push_back(full);
    batch.observations.push_back({ObservationChange::Kind::kAdded, point(i), reference, i});
  }
  batch.light_points.push_back({point(3), MakePosition(random)});
  batch.observations.push_back({ObservationChange::Kind::kRemoved, point(5), reference, 5});
  batch.tracked_frames.push_back({1'000'000'000'000, reference, MakeMotion(random)});
  batch.tracked_frames.push_back({999'900'000'000, reference, Rigid3d::Identity()});
  batch.lost_frames_ns = {1'000'100'000'000, 1'000'200'000'000};
  return batch;
}

SharedUpdate MakeSharedUpdate(std::mt19937& random) {
  SharedUpdate update;
  update.revision = 7;
  update.restart = true;
  update.more_places = true;
  update.global_from_local = MakeSimilarity(random);
  update.apart = true;
  update.in_metres = true;
  update.local_map = kMap;
  for (uint32_t i = 0; i < 3; ++i) {
    SharedKeyframe keyframe;
    keyframe.payload = MakePayload(random, {kOtherMap, i}, 25);
    keyframe.camera_from_global = MakeSimilarity(random);
    if (i > 0) keyframe.parent = {kOtherMap, i - 1};
    keyframe.points.resize(25);
    keyframe.points[3] = {kOtherMap, 30 + i};
    keyframe.points[24] = {kMap, 5};
    update.keyframes.push_back(keyframe);
  }
  auto point = MakePoint<SharedMapPoint>(random, {kOtherMap, 31}, {kOtherMap, 1});
  point.position_in_global = MakePosition(random);
  update.points = {point};
  update.moved_keyframes = {{{kOtherMap, 9}, MakeSimilarity(random)}};
  update.moved_points = {{{kOtherMap, 44}, MakePosition(random)}};
  update.observations = {{ObservationChange::Kind::kRemoved, {kMap, 6}, {kOtherMap, 9}, 12},
                         {ObservationChange::Kind::kAdded, {kOtherMap, 8}, {kOtherMap, 9}, 12}};
  update.landmarks = {{{kMap, 5}, {{kOtherMap, 35}, {kOtherMap, 36}}}};
  update.own_keyframes = {{{kMap, 2}, MakeSimilarity(random), MakeMotion(random)}};
  update.removed_keyframes = {{kOtherMap, 70}};
  update.removed_points = {{kOtherMap, 71}, {kMap, 72}};
  return update;
}

Map MakeMap(std::mt19937& random, LocalMapId local_map, int keyframes) {
  constexpr int kFeatures = 40;
  Map map;
  for (uint32_t i = 0; i < static_cast<uint32_t>(keyframes); ++i) {
    Keyframe keyframe;
    keyframe.payload = MakePayload(random, {local_map, i}, kFeatures);
    keyframe.camera_from_map = MakeMotion(random);
    if (i > 0) keyframe.parent = {local_map, i - 1};
    auto words = std::make_shared<Words>();
    words->direct_index = {{3, {0, 2, 4}}, {17, {1, 5, static_cast<uint32_t>(kFeatures) - 1}}};
    keyframe.words = words;
    map.AddKeyframe(keyframe);
  }
  const auto count = static_cast<uint32_t>(keyframes) * 5;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t first = i % static_cast<uint32_t>(keyframes);
    auto point = MakePoint<MapPoint>(random, {local_map, i}, {local_map, first});
    point.position_in_map = MakePosition(random);
    point.normal_in_map = MakePosition(random).normalized();
    map.AddPoint(point);
    for (uint32_t k = first; k < static_cast<uint32_t>(keyframes) && k < first + 3; ++k) {
      map.AddObservation({local_map, i}, {local_map, k}, (i * 7 + k) % kFeatures);
    }
  }
  if (keyframes > 2) map.AddLoopEdge({local_map, 0}, {local_map, 2});
  return map;
}

Overlap MakeOverlap(std::mt19937& random, KeyframeId query, KeyframeId candidate) {
  Overlap overlap;
  overlap.query = query;
  overlap.candidate = candidate;
  overlap.candidate_from_query = MakeSimilarity(random);
  Matrix7d A;
  for (double& entry : A.reshaped()) entry = std::uniform_real_distribution<double>(-1, 1)(random);
  overlap.covariance = A * A.transpose();
  overlap.covariance.triangularView<Eigen::StrictlyLower>() = overlap.covariance.transpose();
  overlap.inliers = {{{query.local_map, 1}, {candidate.local_map, 4}},
                     {{query.local_map, 2}, {candidate.local_map, 3}}};
  overlap.evidence = {.shared_words = 30,
                      .word_matches = 25,
                      .ransac_inliers = 20,
                      .guided_matches = 22,
                      .refined_inliers = 21,
                      .projected_matches = 60,
                      .visible_points = 300,
                      .chance_matches = 9,
                      .consistent_keyframes = 2};
  overlap.verdict = OverlapVerdict::kAccepted;
  return overlap;
}

}  // namespace corbslam::test_data
