#include "client_agent/tracking/monocular_start.h"

#include <algorithm>
#include <utility>

#include "slam/map/map.h"
#include "slam/map/scene_depth.h"
#include "slam/matching/projection_matching.h"
#include "slam/optimisation/bundle_adjustment.h"

namespace corbslam::client_agent {
namespace {

// With fewer the first frame is too far back (ORB-SLAM, T-RO 2015, section IV).
constexpr size_t kFewestMatches = 100;
// A beginning holds so many points at least once both frames were adjusted.
constexpr size_t kFewestPoints = 50;
constexpr double kSearchRadius_px = 100;
constexpr int kMaxDistance = 50;
constexpr double kMaxRatio = 0.9;
constexpr int kAdjustmentIterations = 20;

// The ids that both frames have while they are adjusted.
constexpr LocalMapId kTrial = {1};
constexpr KeyframeId kFirst = {kTrial, 0};
constexpr KeyframeId kSecond = {kTrial, 1};

void AddView(KeyframeId id, const Frame& frame, const Rigid3d& camera_from_map, Map& map) {
  KeyframePayload payload;
  payload.id = id;
  payload.camera = frame.payload->camera;
  payload.features = frame.payload->features;
  Keyframe keyframe;
  keyframe.payload = std::make_shared<const KeyframePayload>(std::move(payload));
  keyframe.camera_from_map = camera_from_map;
  map.AddKeyframe(std::move(keyframe));
}

// Adjusts both views; the scale that it leaves is none.
bool Adjust(Map& map) {
  BundleScope scope;
  scope.fixed_keyframes = {kFirst};
  scope.free_keyframes = {kSecond};
  for (const auto& [id, point] : map.points()) scope.free_points.push_back(id);
  BundleOptions options;
  options.max_iterations = kAdjustmentIterations;
  const absl::StatusOr<BundleResult> result = AdjustBundle(map, scope, options);
  if (!result.ok()) return false;
  ApplyBundle(*result, map);
  return true;
}

// Makes the median depth before the first camera 1.
bool SetUnit(Map& map) {
  const std::optional<double> median = MedianDepth(map, *map.FindKeyframe(kFirst));
  if (!median.has_value() || !(*median > 0)) return false;
  Rigid3d second = map.FindKeyframe(kSecond)->camera_from_map;
  second.translation /= *median;
  map.SetPose(kSecond, second);
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> scaled;
  for (const auto& [id, point] : map.points()) {
    scaled.emplace_back(id, point.position_in_map / *median);
  }
  for (const auto& [id, position] : scaled) map.SetPosition(id, position);
  return true;
}

// Takes the points that both views still see, and the depths that they have in the second.
bool ReadOut(const Map& map, MonocularBeginning& beginning) {
  const Rigid3d& second = map.FindKeyframe(kSecond)->camera_from_map;
  beginning.first.camera_from_map = Rigid3d::Identity();
  beginning.second.camera_from_map = second;
  for (const auto& [id, point] : map.points()) {
    const auto in_first = point.observations.find(kFirst);
    const auto in_second = point.observations.find(kSecond);
    if (in_first == point.observations.end() || in_second == point.observations.end()) continue;
    const double depth = (second * point.position_in_map).z();
    if (!(point.position_in_map.z() > 0) || !(depth > 0)) continue;
    beginning.points.push_back({in_first->second, in_second->second, point.position_in_map});
    beginning.second.found_depths.push_back({in_second->second, depth});
  }
  return beginning.points.size() >= kFewestPoints;
}

}  // namespace

void MonocularStart::BeginWith(const Frame& frame) {
  first_ = frame;
  last_px_.clear();
  for (const Keypoint& keypoint : frame.keypoints()) last_px_.push_back(keypoint.Pixel());
}

std::vector<MonocularStart::Pair> MonocularStart::Match(const Frame& frame) {
  std::vector<SearchWindow> windows;
  windows.reserve(last_px_.size());
  for (size_t i = 0; i < last_px_.size(); ++i) {
    const Keypoint& keypoint = first_->keypoints()[i];
    SearchWindow window;
    window.pixel = last_px_[i];
    window.radius_px = kSearchRadius_px;
    window.min_octave = keypoint.octave;
    window.max_octave = keypoint.octave;
    window.descriptor = first_->descriptors()[i];
    window.angle_rad = keypoint.angle_rad;
    windows.push_back(window);
  }
  const std::vector<uint32_t> matches = MatchWindows(
      windows, *frame.payload, {},
      {.max_distance = kMaxDistance, .max_ratio = kMaxRatio, .check_orientation = true});
  std::vector<Pair> pairs;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] == kNoMatch) continue;
    pairs.push_back({static_cast<uint32_t>(i), matches[i]});
    last_px_[i] = frame.keypoints()[matches[i]].Pixel();
  }
  return pairs;
}

std::vector<TwoViewMatch> MonocularStart::PixelsOf(const std::vector<Pair>& pairs,
                                                   const Frame& frame) const {
  std::vector<TwoViewMatch> matches;
  matches.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    const Keypoint& first = first_->keypoints()[pair.in_first];
    matches.push_back({first.Pixel(), frame.keypoints()[pair.in_second].Pixel(),
                       ScalePyramid::Variance_px2(first.octave)});
  }
  return matches;
}

std::optional<MonocularBeginning> MonocularStart::Add(const Frame& frame) {
  verdict_ = TwoViewVerdict::kFewMatches;
  if (!first_.has_value()) {
    BeginWith(frame);
    return std::nullopt;
  }
  const std::vector<Pair> pairs = Match(frame);
  if (pairs.size() < kFewestMatches) {
    BeginWith(frame);
    return std::nullopt;
  }
  const TwoViewGeometry geometry =
      FindTwoViewGeometry(frame.camera(), PixelsOf(pairs, frame), {.seed = seed_});
  verdict_ = geometry.verdict;
  if (geometry.verdict != TwoViewVerdict::kFound) return std::nullopt;
  Map map;
  AddView(kFirst, *first_, Rigid3d::Identity(), map);
  AddView(kSecond, frame, geometry.two_from_one, map);
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (!geometry.points[i].has_value()) continue;
    MapPoint point;
    point.id = {kTrial, static_cast<uint32_t>(i)};
    point.position_in_map = geometry.points[i]->x_in_1;
    point.reference = kFirst;
    const MapPointId id = point.id;
    map.AddPoint(std::move(point));
    map.AddObservation(id, kFirst, pairs[i].in_first);
    map.AddObservation(id, kSecond, pairs[i].in_second);
  }
  MonocularBeginning beginning{*first_, frame, {}};
  if (!Adjust(map) || !SetUnit(map) || !ReadOut(map, beginning)) {
    verdict_ = TwoViewVerdict::kAmbiguous;
    return std::nullopt;
  }
  first_.reset();
  return beginning;
}

}  // namespace corbslam::client_agent
