#include "slam/evaluation/trajectory.h"

#include <algorithm>
#include <compare>
#include <functional>
#include <optional>
#include <queue>
#include <utility>

namespace corbslam {
namespace {

bool IsEarlier(const StampedPose& a, const StampedPose& b) {
  return a.timestamp_ns < b.timestamp_ns;
}

// The true poses around one time, from the nearest outwards.
class Outwards {
 public:
  Outwards(const Trajectory& truth, int64_t time_ns)
      : truth_(truth),
        time_ns_(time_ns),
        after_(static_cast<size_t>(
            std::lower_bound(truth.begin(), truth.end(), StampedPose{time_ns, {}}, IsEarlier) -
            truth.begin())),
        before_(after_) {}

  // Returns how far the next one is in time; nullopt after the last. Of two that are equally far,
  // the earlier one is first.
  std::optional<int64_t> gap_ns() const {
    if (before_ == 0 && after_ == truth_.size()) return std::nullopt;
    return IsBefore() ? GapBefore_ns() : GapAfter_ns();
  }
  // Returns its index and moves on.
  size_t Take() { return IsBefore() ? --before_ : after_++; }

 private:
  int64_t GapBefore_ns() const { return time_ns_ - truth_[before_ - 1].timestamp_ns; }
  int64_t GapAfter_ns() const { return truth_[after_].timestamp_ns - time_ns_; }
  bool IsBefore() const {
    return before_ > 0 && (after_ == truth_.size() || GapBefore_ns() <= GapAfter_ns());
  }

  const Trajectory& truth_;
  int64_t time_ns_;
  size_t after_;
  size_t before_;  // The one before this index is next on that side.
};

struct Candidate {
  int64_t gap_ns = 0;
  size_t estimate = 0;
  friend auto operator<=>(const Candidate&, const Candidate&) = default;
};

// Returns the index of each estimate's true pose; nullopt where none is left for it.
std::vector<std::optional<size_t>> MatchNearestFirst(const Trajectory& estimate,
                                                     const Trajectory& truth, int64_t max_gap_ns) {
  std::vector<Outwards> searches;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> nearest;
  const auto propose = [&](size_t i) {
    const std::optional<int64_t> gap_ns = searches[i].gap_ns();
    if (gap_ns.has_value() && *gap_ns <= max_gap_ns) nearest.push({*gap_ns, i});
  };
  for (size_t i = 0; i < estimate.size(); ++i) {
    searches.emplace_back(truth, estimate[i].timestamp_ns);
    propose(i);
  }
  std::vector<std::optional<size_t>> chosen(estimate.size());
  std::vector<bool> is_used(truth.size(), false);
  while (!nearest.empty()) {
    const size_t i = nearest.top().estimate;
    nearest.pop();
    const size_t pose = searches[i].Take();
    if (is_used[pose]) {
      propose(i);
      continue;
    }
    is_used[pose] = true;
    chosen[i] = pose;
  }
  return chosen;
}

}  // namespace

std::vector<PosePair> AssociateByTime(const Trajectory& estimate, const Trajectory& truth,
                                      int64_t max_gap_ns) {
  const auto chosen = MatchNearestFirst(estimate, truth, max_gap_ns);
  std::vector<PosePair> pairs;
  for (size_t i = 0; i < estimate.size(); ++i) {
    if (chosen[i].has_value()) pairs.push_back({estimate[i], truth[*chosen[i]]});
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
