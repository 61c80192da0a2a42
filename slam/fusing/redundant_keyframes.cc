#include "slam/fusing/redundant_keyframes.h"

#include <set>
#include <utility>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_set.h"

namespace corbslam {
namespace {

constexpr int kOctaveSlack = 1;

class Selection {
 public:
  Selection(const Map& map, const absl::btree_set<KeyframeId>& kept,
            const RedundancyOptions& options)
      : map_(map), options_(options), left_(map.keyframes().size()) {
    for (const auto& [id, keyframe] : map.keyframes()) {
      if (kept.contains(id) || !keyframe.parent.IsValid()) continue;
      Rank(id);
    }
  }

  std::vector<KeyframeId> Run() {
    std::vector<KeyframeId> redundant;
    while (!ranked_.empty()) {
      const auto [share, id] = *ranked_.rbegin();
      const bool is_redundant = options_.seen_share > 0 && share >= options_.seen_share;
      const bool is_too_many = options_.target_keyframes > 0 && left_ > options_.target_keyframes;
      if (!is_redundant && !is_too_many) break;
      redundant.push_back(id);
      Drop(id);
    }
    return redundant;
  }

 private:
  int OctaveOf(KeyframeId keyframe, uint32_t keypoint) const {
    return map_.FindKeyframe(keyframe)->keypoints()[keypoint].octave;
  }

  bool IsSeenEnough(const MapPoint& point, KeyframeId by) const {
    const int octave = OctaveOf(by, point.observations.at(by));
    int others = 0;
    for (const auto& [id, keypoint] : point.observations) {
      if (id == by || gone_.contains(id)) continue;
      if (OctaveOf(id, keypoint) <= octave + kOctaveSlack) ++others;
      if (others == options_.min_others) return true;
    }
    return false;
  }

  // Returns the share of its points that enough others see; below 0 where it sees none.
  double SeenShare(const Keyframe& keyframe) const {
    int points = 0;
    int seen = 0;
    for (const MapPointId& id : keyframe.points) {
      const MapPoint* point = id.IsValid() ? map_.FindPoint(id) : nullptr;
      if (point == nullptr) continue;
      ++points;
      if (IsSeenEnough(*point, keyframe.id())) ++seen;
    }
    return points == 0 ? -1 : static_cast<double>(seen) / points;
  }

  void Rank(KeyframeId id) {
    const double share = SeenShare(*map_.FindKeyframe(id));
    if (share < 0) return;
    shares_[id] = share;
    ranked_.emplace(share, id);
  }

  // One keyframe less sees what it saw: its neighbours' shares are not what they were.
  void Drop(KeyframeId id) {
    gone_.insert(id);
    --left_;
    ranked_.erase({shares_.at(id), id});
    shares_.erase(id);
    absl::btree_set<KeyframeId> neighbours;
    for (const MapPointId& point_id : map_.FindKeyframe(id)->points) {
      const MapPoint* point = point_id.IsValid() ? map_.FindPoint(point_id) : nullptr;
      if (point == nullptr) continue;
      for (const auto& [other, keypoint] : point->observations) neighbours.insert(other);
    }
    for (const KeyframeId& other : neighbours) {
      const auto it = shares_.find(other);
      if (it == shares_.end()) continue;
      ranked_.erase({it->second, other});
      Rank(other);
    }
  }

  const Map& map_;
  const RedundancyOptions& options_;
  size_t left_;
  absl::flat_hash_set<KeyframeId> gone_;
  // Shares of the keyframes that may go.
  absl::btree_map<KeyframeId, double> shares_;
  std::set<std::pair<double, KeyframeId>> ranked_;
};

}  // namespace

std::vector<KeyframeId> FindRedundantKeyframes(const Map& map,
                                               const absl::btree_set<KeyframeId>& kept,
                                               const RedundancyOptions& options) {
  if (options.seen_share <= 0 && options.target_keyframes == 0) return {};
  return Selection(map, kept, options).Run();
}

}  // namespace corbslam
