#include "tests/fault/dear_map.h"

#include <algorithm>
#include <utility>

namespace corbslam::tests {
namespace {

using Kind = ObservationChange::Kind;

// Whose points the wide keyframe sees. There is no such local map.
constexpr LocalMapId kNobody{0xdeadbeef};
// Indices of points that never arrive.
constexpr uint32_t kNeverArrives = 1u << 31;
constexpr size_t kItemLimit = 65'000;
constexpr size_t kParkedLimit = 65'000;

// Moves by millimetres, elsewhere in each round.
double Shift_m(size_t i, uint32_t round) {
  return 1e-3 * static_cast<double>((i + round * 7) % 11);
}

}  // namespace

size_t CountItems(const MapUpdateBatch& batch) {
  return batch.cameras.size() + batch.full_keyframes.size() + batch.full_points.size() +
         batch.light_keyframes.size() + batch.light_points.size() + batch.replacements.size() +
         batch.observations.size() + batch.removed_points.size() + batch.removed_keyframes.size() +
         batch.loop_edges.size() + batch.tracked_frames.size() + batch.lost_frames_ns.size();
}

DearMap::DearMap(LocalMapId first, const DearSizes& sizes)
    : first_(first),
      second_{first.value + 1},
      sizes_(sizes),
      camera_(std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})),
      next_point_(static_cast<uint32_t>(sizes.keyframes * sizes.features)) {}

MapUpdateBatch DearMap::Empty(LocalMapId local_map) const {
  MapUpdateBatch batch;
  batch.local_map = local_map;
  return batch;
}

FullKeyframe DearMap::MakeKeyframe(KeyframeId id, KeyframeId parent, size_t features) const {
  Features seen;
  seen.keypoints.resize(features);
  seen.descriptors.resize(features);
  for (size_t i = 0; i < features; ++i) {
    seen.keypoints[i].x_px = static_cast<float>(i % 640);
    seen.keypoints[i].y_px = static_cast<float>(i / 640 % 480);
    seen.descriptors[i].words = {id.index * 0x9e3779b97f4a7c15u, i * 0xc2b2ae3d27d4eb4fu, i, 1};
  }
  Rigid3d pose = Rigid3d::Identity();
  pose.translation.z() = -0.1 * id.index;
  return {MakeKeyframePayload(id, int64_t{100'000'000} * id.index, 0, camera_, std::move(seen)),
          pose, parent};
}

FullMapPoint DearMap::MakePoint(MapPointId id, KeyframeId reference) const {
  const Eigen::Vector3d position(0, 0, 0.1 * reference.index + 5);
  return {id, position, reference, Descriptor(), Eigen::Vector3d::UnitZ(), 1, 20};
}

MapUpdateBatch DearMap::MakeChain() const {
  MapUpdateBatch batch = Empty(first_);
  batch.cameras = {camera_};
  for (size_t i = 0; i < sizes_.keyframes; ++i) {
    const KeyframeId parent = i == 0 ? KeyframeId() : Chain(i - 1);
    batch.full_keyframes.push_back(MakeKeyframe(Chain(i), parent, sizes_.features));
    for (size_t j = 0; j < sizes_.features; ++j) {
      batch.full_points.push_back(MakePoint(PointOf(i, j), Chain(i)));
      batch.observations.push_back(
          {Kind::kAdded, PointOf(i, j), Chain(i), static_cast<uint32_t>(j)});
    }
  }
  batch.full_keyframes.push_back(MakeKeyframe(Wide(), Chain(0), sizes_.wide_features));
  return batch;
}

MapUpdateBatch DearMap::MakeReversed() const {
  MapUpdateBatch batch = Empty(second_);
  batch.cameras = {camera_};
  for (size_t i = 0; i < sizes_.reversed; ++i) {
    const KeyframeId parent = i + 1 == sizes_.reversed ? KeyframeId() : Reversed(i + 1);
    batch.full_keyframes.push_back(MakeKeyframe(Reversed(i), parent, 1));
  }
  return batch;
}

std::vector<DearBatch> DearMap::Foundation() const {
  return {{"a chain of keyframes", MakeChain()}, {"a chain backwards", MakeReversed()}};
}

MapUpdateBatch DearMap::MoveChain(uint32_t round) const {
  MapUpdateBatch batch = Empty(first_);
  batch.points_follow = true;
  for (size_t i = 0; i < sizes_.keyframes; ++i) {
    LightKeyframe light{Chain(i), Rigid3d::Identity(), i == 0 ? KeyframeId() : Chain(i - 1)};
    light.camera_from_local.translation.z() = -0.1 * static_cast<double>(i) + Shift_m(i, round);
    batch.light_keyframes.push_back(light);
  }
  return batch;
}

// On the one before the last one, or on the last one: each is looked for up to the root.
MapUpdateBatch DearMap::ChangeParents(uint32_t round) const {
  MapUpdateBatch batch = Empty(first_);
  const size_t back = 1 + (round + 1) % 2;
  for (size_t i = 2; i < sizes_.keyframes; ++i) {
    batch.light_keyframes.push_back({Chain(i), Rigid3d::Identity(), Chain(i - back)});
  }
  return batch;
}

MapUpdateBatch DearMap::NameForeignParents() const {
  MapUpdateBatch batch = Empty(second_);
  for (size_t i = 0; i < sizes_.reversed; ++i) {
    batch.light_keyframes.push_back({Reversed(i), Rigid3d::Identity(), {kNobody, 0}});
  }
  return batch;
}

MapUpdateBatch DearMap::MovePoints(uint32_t round) const {
  MapUpdateBatch batch = Empty(first_);
  const size_t points = std::min(sizes_.items, sizes_.keyframes * sizes_.features);
  for (size_t i = 0; i < points; ++i) {
    batch.light_points.push_back(
        {MapPointId{first_, static_cast<uint32_t>(i)}, Eigen::Vector3d(Shift_m(i, round), 0, 5)});
  }
  return batch;
}

// Every keyframe loses sight of its points, and sees them again.
MapUpdateBatch DearMap::SeeAndUnsee() const {
  MapUpdateBatch batch = Empty(first_);
  const size_t points = sizes_.keyframes * sizes_.features;
  // Those of the crowd come and go by themselves.
  const size_t first = std::min(points, sizes_.crowd * sizes_.features);
  for (size_t n = 0; first < points && batch.observations.size() + 2 <= sizes_.items; ++n) {
    const size_t point = first + n % (points - first);
    const KeyframeId keyframe = Chain(point / sizes_.features);
    const MapPointId id{first_, static_cast<uint32_t>(point)};
    const auto keypoint = static_cast<uint32_t>(point % sizes_.features);
    batch.observations.push_back({Kind::kRemoved, id, keyframe, keypoint});
    batch.observations.push_back({Kind::kAdded, id, keyframe, keypoint});
  }
  return batch;
}

// Many keyframes come to see the first one's points, and lose sight of them: each time with all the
// others that do, which is one and a half times the crowd's square for each point, and just below
// the 500,000 steps that a batch may take.
MapUpdateBatch DearMap::CrowdAndPart() const {
  MapUpdateBatch batch = Empty(first_);
  for (const Kind kind : {Kind::kAdded, Kind::kRemoved}) {
    for (size_t i = 1; i < sizes_.crowd; ++i) {
      for (size_t j = 0; j < sizes_.features; ++j) {
        batch.observations.push_back({kind, PointOf(0, j), Chain(i), static_cast<uint32_t>(j)});
      }
    }
  }
  return batch;
}

// More steps than may be: every keyframe loses sight of a point again and again while it is seen
// by others.
MapUpdateBatch DearMap::TooManySteps() const {
  MapUpdateBatch batch = CrowdAndPart();
  const std::vector<ObservationChange> once = batch.observations;
  constexpr size_t kStepLimit = 500'000;
  const size_t steps_at_least = once.size() * sizes_.crowd / 4;
  for (size_t steps = 0; steps <= kStepLimit; steps += steps_at_least) {
    batch.observations.insert(batch.observations.end(), once.begin(), once.end());
  }
  return batch;
}

// The wide keyframe's keypoints change among them what they see of nobody's.
MapUpdateBatch DearMap::SeeForeign(uint32_t round) const {
  MapUpdateBatch batch = Empty(first_);
  const size_t count = std::min(sizes_.items, 2 * sizes_.wide_features);
  for (size_t n = 0; n < count; ++n) {
    const auto point = static_cast<uint32_t>((n + round) % sizes_.wide_features);
    const auto keypoint =
        static_cast<uint32_t>((n + n / sizes_.wide_features) % sizes_.wide_features);
    batch.observations.push_back({Kind::kAdded, {kNobody, point}, Wide(), keypoint});
  }
  return batch;
}

MapUpdateBatch DearMap::ParkAll() const {
  MapUpdateBatch batch = Empty(first_);
  for (size_t i = 0; i < sizes_.parked; ++i) {
    const MapPointId never{first_, kNeverArrives + static_cast<uint32_t>(i)};
    batch.observations.push_back({Kind::kAdded, never, Chain(0), 0});
  }
  return batch;
}

// With one new point, all that waits is looked at again.
MapUpdateBatch DearMap::RetryParked() {
  MapUpdateBatch batch = Empty(first_);
  batch.full_points.push_back(MakePoint({first_, next_point_++}, Chain(0)));
  return batch;
}

// New points, each of which gives way to the next; then all are seen by their first names.
MapUpdateBatch DearMap::ReplaceInAChain() {
  MapUpdateBatch batch = Empty(first_);
  const size_t points = sizes_.items / 9;
  for (size_t i = 0; i < points; ++i) {
    batch.full_points.push_back(
        MakePoint({first_, next_point_ + static_cast<uint32_t>(i)}, Chain(0)));
  }
  for (uint32_t i = 0; i + 1 < points; ++i) {
    batch.replacements.push_back({{first_, next_point_ + i}, {first_, next_point_ + i + 1}});
  }
  for (uint32_t i = 0; i < points; ++i) {
    batch.observations.push_back({Kind::kAdded, {first_, next_point_ + i}, Chain(1), 0});
  }
  next_point_ += static_cast<uint32_t>(points);
  return batch;
}

// Behind the wide one; each hangs on the root.
MapUpdateBatch DearMap::FillWithFeatures(size_t keyframes, size_t features) const {
  MapUpdateBatch batch = Empty(first_);
  for (size_t i = 0; i < keyframes; ++i) {
    batch.full_keyframes.push_back(
        MakeKeyframe(Chain(sizes_.keyframes + 1 + i), Chain(0), features));
  }
  return batch;
}

std::vector<DearBatch> DearMap::Round(uint32_t round) {
  std::vector<DearBatch> batches = {
      {"keyframes moved, points follow", MoveChain(round)},
      {"parents back and forth", ChangeParents(round)},
      {"parents of another's", NameForeignParents()},
      {"points moved", MovePoints(round)},
      {"observations added, withdrawn", SeeAndUnsee()},
      {"a crowd sees the same points", CrowdAndPart()},
      {"sights of others' points", SeeForeign(round)},
      {"replacements in a chain", ReplaceInAChain()},
  };
  // Known keyframes would cost nothing, and what is parked stays so.
  if (round == 0) {
    batches.push_back({"keyframes full of features",
                       FillWithFeatures(sizes_.full_keyframes, sizes_.wide_features)});
    batches.push_back({"references that wait", ParkAll()});
  }
  for (int i = 0; i < 5; ++i) batches.push_back({"one point, all that waits", RetryParked()});
  return batches;
}

std::vector<DearMap::Refused> DearMap::BeyondLimits() const {
  std::vector<Refused> refused;
  Refused items{"too many items", Empty(first_), "items; the limit is 65000"};
  for (size_t i = 0; i <= kItemLimit; ++i) {
    items.batch.observations.push_back({Kind::kRemoved, PointOf(0, 0), Chain(0), 0});
  }
  refused.push_back(std::move(items));
  // 21 MB.
  Refused bytes{"too many bytes", FillWithFeatures(25, 20'000), "the limit is 16777216"};
  refused.push_back(std::move(bytes));
  Refused parked{"too much that waits", ParkAll(), "the limit is 65000"};
  const MapUpdateBatch more = ParkAll();
  while (parked.batch.observations.size() <= kParkedLimit) {
    parked.batch.observations.push_back(more.observations.front());
  }
  refused.push_back(std::move(parked));
  refused.push_back({"too many steps", TooManySteps(), "the limit is 500000"});
  Refused twice{"a keyframe moved twice", MoveChain(0), "comes twice"};
  twice.batch.light_keyframes.push_back(twice.batch.light_keyframes.front());
  refused.push_back(std::move(twice));
  return refused;
}

}  // namespace corbslam::tests
