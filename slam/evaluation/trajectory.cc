#include "slam/evaluation/trajectory.h"

#include <algorithm>
#include <cstdlib>

namespace corbslam {
namespace {

bool IsEarlier(const StampedPose& a, const StampedPose& b) {
  return a.timestamp_ns < b.timestamp_ns;
}

// Null for an empty truth.
const StampedPose* FindNearest(const Trajectory& truth, int64_t timestamp_ns) {
  if (truth.empty()) return nullptr;
  const auto after =
      std::lower_bound(truth.begin(), truth.end(), StampedPose{timestamp_ns, {}}, IsEarlier);
  if (after == truth.begin()) return &*after;
  const auto before = std::prev(after);
  if (after == truth.end()) return &*before;
  return timestamp_ns - before->timestamp_ns <= after->timestamp_ns - timestamp_ns ? &*before
                                                                                   : &*after;
}

}  // namespace

std::vector<PosePair> AssociateByTime(const Trajectory& estimate, const Trajectory& truth,
                                      int64_t max_gap_ns) {
  std::vector<PosePair> pairs;
  pairs.reserve(estimate.size());
  for (const StampedPose& pose : estimate) {
    const StampedPose* nearest = FindNearest(truth, pose.timestamp_ns);
    if (nearest == nullptr) continue;
    if (std::abs(nearest->timestamp_ns - pose.timestamp_ns) > max_gap_ns) continue;
    pairs.push_back({pose, *nearest});
  }
  return pairs;
}

void SortByTime(Trajectory& trajectory) {
  std::stable_sort(trajectory.begin(), trajectory.end(), IsEarlier);
}

Trajectory KeepFrom(const Trajectory& trajectory, int64_t first_ns) {
  Trajectory kept;
  for (const StampedPose& pose : trajectory) {
    if (pose.timestamp_ns >= first_ns) kept.push_back(pose);
  }
  return kept;
}

Trajectory MergeByTime(const std::vector<Trajectory>& trajectories) {
  Trajectory merged;
  for (const Trajectory& trajectory : trajectories) {
    merged.insert(merged.end(), trajectory.begin(), trajectory.end());
  }
  SortByTime(merged);
  const auto has_same_time = [](const StampedPose& a, const StampedPose& b) {
    return a.timestamp_ns == b.timestamp_ns;
  };
  merged.erase(std::unique(merged.begin(), merged.end(), has_same_time), merged.end());
  return merged;
}

double PathLength_m(const Trajectory& trajectory) {
  double length_m = 0;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    length_m += (trajectory[i].world_from_camera.translation -
                 trajectory[i - 1].world_from_camera.translation)
                    .norm();
  }
  return length_m;
}

}  // namespace corbslam
