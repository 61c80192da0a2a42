#include "slam/fusing/trial_merges.h"

#include <algorithm>
#include <utility>

#include "absl/container/btree_map.h"

namespace corbslam {
namespace {

TrialMerge::Side SideOf(const MapPoint& point) {
  TrialMerge::Side side{point.position_in_map, {}};
  for (const auto& [keyframe, keypoint] : point.observations) side.observers.push_back(keyframe);
  return side;
}

class Judge {
 public:
  Judge(const Map& map, const BundleResult& adjusted) : map_(map) {
    for (const PoseUpdate& update : adjusted.poses) {
      result_.poses[update.id] = update.camera_from_map;
    }
    for (const PositionUpdate& update : adjusted.positions) {
      result_.positions[update.id] = update.position_in_map;
    }
    for (const ObservationKey& outlier : adjusted.outliers) {
      outliers_[outlier.point].push_back(outlier.keyframe);
    }
  }

  void Decide(const TrialMerge& trial) {
    const bool fits_survivor = Fits(trial.survivor, trial.merge.survivor);
    const bool fits_member = Fits(trial.member, trial.merge.survivor);
    if (fits_survivor && fits_member) {
      result_.merges.push_back(trial.merge);
      return;
    }
    outliers_.erase(trial.merge.survivor);
    const auto adjusted = result_.positions.find(trial.merge.survivor);
    if (adjusted == result_.positions.end()) {
      result_.positions[trial.merge.member] = GoneAlong(trial.member);
      return;
    }
    result_.positions[trial.merge.member] =
        fits_member ? adjusted->second : GoneAlong(trial.member);
    if (!fits_survivor) adjusted->second = GoneAlong(trial.survivor);
  }

  WeldingResult Take() {
    for (const auto& [point, keyframes] : outliers_) {
      for (const KeyframeId& keyframe : keyframes) result_.rejected.push_back({point, keyframe});
    }
    return std::move(result_);
  }

 private:
  bool Fits(const TrialMerge::Side& side, MapPointId merged) const {
    const auto it = outliers_.find(merged);
    if (it == outliers_.end()) return true;
    const auto out = std::ranges::count_if(side.observers, [&](KeyframeId observer) {
      return std::ranges::find(it->second, observer) != it->second.end();
    });
    return 2 * static_cast<size_t>(out) <= side.observers.size();
  }

  // Returns where the side's first observer saw the point, carried along with that observer.
  Eigen::Vector3d GoneAlong(const TrialMerge::Side& side) const {
    if (side.observers.empty()) return side.position_in_map;
    const KeyframeId observer = side.observers.front();
    const auto after = result_.poses.find(observer);
    if (after == result_.poses.end()) return side.position_in_map;
    const Rigid3d& before = map_.FindKeyframe(observer)->camera_from_map;
    return after->second.Inverse() * (before * side.position_in_map);
  }

  const Map& map_;
  WeldingResult result_;
  absl::btree_map<MapPointId, std::vector<KeyframeId>> outliers_;
};

}  // namespace

std::optional<TrialMerge> MergeOnTrial(const FuseMapsResult::Merge& merge, Map& map) {
  const MapPoint* survivor = map.FindPoint(merge.survivor);
  const MapPoint* member = map.FindPoint(merge.member);
  if (survivor == nullptr || member == nullptr) return std::nullopt;
  TrialMerge trial{merge, SideOf(*survivor), SideOf(*member)};
  if (!map.ReplacePoint(merge.member, merge.survivor)) return std::nullopt;
  return trial;
}

WeldingResult JudgeMerges(const std::vector<TrialMerge>& trials, const Map& map,
                          const BundleResult& adjusted) {
  Judge judge(map, adjusted);
  for (const TrialMerge& trial : trials) judge.Decide(trial);
  return judge.Take();
}

}  // namespace corbslam
