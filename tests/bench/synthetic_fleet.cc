#include "tests/bench/synthetic_fleet.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace corbslam::tests {
namespace {

constexpr double kAhead_m = 5;
constexpr size_t kMovedKeyframes = 5;
constexpr size_t kReplacements = 2;

}  // namespace

SyntheticFleet::SyntheticFleet(const FleetOptions& options)
    : options_(options),
      camera_(std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})),
      random_(options.seed),
      robots_(options.robots),
      first_seen_(options.places) {
  for (size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].local_map = {i + 1};
    robots_[i].begin = i * options_.spacing % options_.places;
    robots_[i].seen.resize(options_.places);
  }
}

Rigid3d SyntheticFleet::CameraFromRing(size_t place) const {
  const double turn =
      2 * std::numbers::pi * static_cast<double>(place) / static_cast<double>(options_.places);
  const double radius = static_cast<double>(options_.places) / (2 * std::numbers::pi);
  // The camera looks along the ring, its x axis outwards.
  Eigen::Matrix3d ring_from_camera;
  ring_from_camera << std::cos(turn), 0, -std::sin(turn), 0, 1, 0, std::sin(turn), 0,
      std::cos(turn);
  const Eigen::Vector3d centre(radius * std::cos(turn), 0, radius * std::sin(turn));
  return Rigid3d{Eigen::Quaterniond(ring_from_camera), centre}.Inverse();
}

Eigen::Vector3d SyntheticFleet::PositionOf(size_t place, size_t i) const {
  const double side = static_cast<double>(i) / static_cast<double>(options_.points_per_place) - 0.5;
  const Eigen::Vector3d in_camera(6 * side, std::sin(37.0 * static_cast<double>(i)), kAhead_m);
  return CameraFromRing(place).Inverse() * in_camera;
}

Descriptor SyntheticFleet::DescriptorOf(size_t place, size_t i) const {
  std::mt19937_64 bits(place * options_.points_per_place + i);
  Descriptor descriptor;
  for (uint64_t& word : descriptor.words) word = bits();
  return descriptor;
}

std::shared_ptr<const KeyframePayload> SyntheticFleet::MakePayload(const Robot& robot,
                                                                   KeyframeId id) {
  Features features;
  features.keypoints.resize(options_.features);
  features.descriptors.resize(options_.features);
  std::uniform_real_distribution<float> pixel(0, 480);
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.x_px = pixel(random_);
    keypoint.y_px = pixel(random_);
    keypoint.disparity_px = 10;
  }
  const size_t place = PlaceOf(robot, id.index);
  for (size_t i = 0; i < options_.features; ++i) {
    const size_t back = i / options_.points_per_place;
    const bool sees = back < kPlacesInSight && back <= id.index;
    Descriptor& descriptor = features.descriptors[i];
    if (sees) {
      descriptor = DescriptorOf((place + options_.places - back) % options_.places,
                                i % options_.points_per_place);
    } else {
      for (uint64_t& word : descriptor.words) word = random_();
    }
  }
  return MakeKeyframePayload(id, int64_t{100'000'000} * id.index, 0, camera_, std::move(features));
}

void SyntheticFleet::SeePlace(size_t place, KeyframeId reference, Robot& robot,
                              MapUpdateBatch& batch) {
  std::vector<MapPointId>& seen = robot.seen[place];
  if (!seen.empty()) return;
  std::vector<MapPointId>& first = first_seen_[place];
  for (size_t i = 0; i < options_.points_per_place; ++i) {
    if (!first.empty() && i % 3 == 0) {
      seen.push_back(first[i]);
      continue;
    }
    const MapPointId id = {robot.local_map, robot.points++};
    const Descriptor descriptor = DescriptorOf(place, i);
    batch.full_points.push_back(
        {id, PositionOf(place, i), reference, descriptor, Eigen::Vector3d::UnitZ(), 1, 20});
    seen.push_back(id);
    ++points_;
  }
  if (first.empty()) first = seen;
}

void SyntheticFleet::Observe(KeyframeId keyframe, const Robot& robot, MapUpdateBatch& batch) const {
  const size_t place = PlaceOf(robot, keyframe.index);
  for (size_t back = 0; back < kPlacesInSight && back <= keyframe.index; ++back) {
    const std::vector<MapPointId>& seen =
        robot.seen[(place + options_.places - back) % options_.places];
    for (size_t i = 0; i < seen.size(); ++i) {
      const size_t keypoint = back * options_.points_per_place + i;
      if (keypoint >= options_.features || !seen[i].IsValid()) continue;
      batch.observations.push_back(
          {ObservationChange::Kind::kAdded, seen[i], keyframe, static_cast<uint32_t>(keypoint)});
    }
  }
}

// Some points of the robot's own give way to what another robot made of the same thing.
void SyntheticFleet::ReplaceSome(size_t place, Robot& robot, MapUpdateBatch& batch) {
  const std::vector<MapPointId>& first = first_seen_[place];
  std::vector<MapPointId>& seen = robot.seen[place];
  size_t replaced = 0;
  for (size_t i = 1; i < seen.size() && replaced < kReplacements; ++i) {
    if (seen[i].local_map != robot.local_map || first[i] == seen[i]) continue;
    batch.replacements.push_back({seen[i], first[i]});
    seen[i] = first[i];
    ++replaced;
  }
}

MapUpdateBatch SyntheticFleet::NextBatch(size_t index) {
  Robot& robot = robots_[index];
  const KeyframeId id = {robot.local_map, robot.keyframes};
  const size_t place = PlaceOf(robot, id.index);
  MapUpdateBatch batch;
  batch.local_map = robot.local_map;
  batch.number = ++robot.keyframes;
  if (id.index == 0) batch.cameras = {camera_};
  const KeyframeId parent =
      id.index == 0 ? KeyframeId() : KeyframeId{robot.local_map, id.index - 1};
  const Rigid3d pose = CameraFromRing(place);
  batch.full_keyframes = {{MakePayload(robot, id), pose, parent}};
  SeePlace(place, id, robot, batch);
  for (LightKeyframe& light : robot.newest) {
    light.camera_from_local.translation.y() += 1e-4;
    batch.light_keyframes.push_back(light);
  }
  robot.newest.push_back({id, pose, parent});
  if (robot.newest.size() > kMovedKeyframes) robot.newest.pop_front();
  Observe(id, robot, batch);
  if (id.index >= kPlacesInSight) {
    ReplaceSome((place + options_.places - kPlacesInSight) % options_.places, robot, batch);
  }
  batch.tracked_frames = {{batch.full_keyframes[0].payload->timestamp_ns, id, {}}};
  return batch;
}

absl::StatusOr<VerifyOverlapResult> BelievingWorker::VerifyOverlap(
    const VerifyOverlapRequest& request, const ProgressCallback&) {
  constexpr double kSamePlace_m = 2;
  VerifyOverlapResult result;
  result.base_revision = request.base_revision;
  const Rigid3d query = request.query_view->FindKeyframe(request.query)->camera_from_map;
  for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
    Overlap overlap;
    overlap.query = request.query;
    overlap.candidate = candidate.id;
    const Rigid3d candidate_from_query =
        request.candidate_view.FindKeyframe(candidate.id)->camera_from_map * query.Inverse();
    overlap.candidate_from_query = Similarity3d::FromRigid(candidate_from_query);
    overlap.covariance = 1e-4 * Matrix7d::Identity();
    const bool same_place = candidate_from_query.translation.norm() < kSamePlace_m;
    if (same_place) overlap.verdict = OverlapVerdict::kAccepted;
    result.overlaps.push_back(overlap);
    if (same_place) break;
  }
  return result;
}

absl::StatusOr<FuseMapsResult> BelievingWorker::FuseMaps(const FuseMapsRequest& request,
                                                         const ProgressCallback&) {
  FuseMapsResult result;
  result.base_revision = request.base_revision;
  result.accepted = true;
  for (const auto& [id, keyframe] : request.source.keyframes()) {
    result.poses.push_back({id, Similarity3d::FromRigid(keyframe.camera_from_map)});
  }
  for (const auto& [id, point] : request.source.points()) {
    result.positions.push_back({id, point.position_in_map});
  }
  return result;
}

absl::StatusOr<AdjustBundleResult> BelievingWorker::AdjustBundle(const AdjustBundleRequest& request,
                                                                 const ProgressCallback&) {
  AdjustBundleResult result;
  result.base_revision = request.base_revision;
  for (const auto& [id, keyframe] : request.view.keyframes()) {
    result.poses.push_back({id, Similarity3d::FromRigid(keyframe.camera_from_map)});
  }
  result.keyframes = static_cast<int>(result.poses.size());
  return result;
}

}  // namespace corbslam::tests
