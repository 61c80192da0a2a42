#include "map_store/retiring/keyframe_choice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "map_store/retiring/session_links.h"

namespace corbslam::map_store {
namespace {

constexpr int kOctaveSlack = 1;
// Poses relative to a stand-in are rigid: where units differ by more than this share, it is none.
constexpr double kSameUnits = 0.01;

class Choice {
 public:
  Choice(const RetiringView& view, const SightsOfLandmarks& sights,
         const absl::flat_hash_set<MapPointId>& faded, const ChoiceOptions& options)
      : view_(view), sights_(sights), faded_(faded), options_(options), links_(view.overlaps) {}

  std::vector<RetiredKeyframe> Run() {
    for (const KeyframeId& id : Order()) {
      if (!MayGo(id)) continue;
      going_.push_back(id);
      gone_.insert(id);
      links_.Cut(id);
    }
    std::vector<RetiredKeyframe> retired;
    for (const KeyframeId& id : going_) {
      if (auto one = Describe(id)) retired.push_back(*std::move(one));
    }
    return retired;
  }

 private:
  std::vector<KeyframeId> Order() const {
    std::vector<std::tuple<bool, size_t, double, KeyframeId>> ranked;
    for (const KeyframeId& id : view_.candidates) {
      const Keyframe* keyframe = view_.map.FindKeyframe(id);
      if (keyframe == nullptr || !view_.parents.contains(id)) continue;
      ranked.emplace_back(links_.Holds(id), view_.closed.at(id.local_map).order,
                          -SeenShare(*keyframe), id);
    }
    std::sort(ranked.begin(), ranked.end());
    std::vector<KeyframeId> order;
    for (const auto& [holds, session, share, id] : ranked) order.push_back(id);
    return order;
  }

  bool MayGo(KeyframeId id) const {
    return SeenShare(*view_.map.FindKeyframe(id)) >= options_.seen_share && !links_.IsNeeded(id) &&
           FindStandIn(id).IsValid();
  }

  // Returns the share of the landmarks that it observes of which enough others see; below 0 where
  // it observes none.
  double SeenShare(const Keyframe& keyframe) const {
    int landmarks = 0;
    int seen = 0;
    for (uint32_t i = 0; i < keyframe.points.size(); ++i) {
      const LandmarkSights* sights = Find(keyframe.points[i]);
      if (sights == nullptr) continue;
      ++landmarks;
      const int octave = keyframe.keypoints()[i].octave;
      seen += IsSeenEnough(keyframe.points[i], *sights, keyframe.id(), octave);
    }
    return landmarks == 0 ? -1 : static_cast<double>(seen) / landmarks;
  }

  const LandmarkSights* Find(MapPointId landmark) const {
    if (!landmark.IsValid() || faded_.contains(landmark)) return nullptr;
    const auto it = sights_.find(landmark);
    return it == sights_.end() ? nullptr : &it->second;
  }

  bool IsSeenEnough(MapPointId landmark, const LandmarkSights& sights, KeyframeId by,
                    int octave) const {
    int others = 0;
    bool observed = false;
    bool at_home = false;
    for (const LandmarkSights::Seen& seen : sights.seen) {
      if (seen.keyframe == by || gone_.contains(seen.keyframe)) continue;
      others += seen.octave <= octave + kOctaveSlack;
      if (!seen.observed) continue;
      observed = true;
      at_home = at_home || IsAtHome(landmark, seen.keyframe.local_map);
    }
    // A point that only keyframes of other local maps saw would go, and they would lose it.
    return others >= options_.min_others && (at_home || !observed);
  }

  bool IsAtHome(MapPointId landmark, LocalMapId local_map) const {
    return std::ranges::any_of(view_.landmarks.at(landmark), [local_map](MapPointId member) {
      return member.local_map == local_map;
    });
  }

  // Returns the keyframe that stays and sees most of what this one observes; of those that see as
  // much, one of its own local map, then the least. Invalid: none sees enough.
  KeyframeId FindStandIn(KeyframeId id) const {
    std::map<KeyframeId, int> shared;
    for (const MapPointId& landmark : view_.map.FindKeyframe(id)->points) {
      const LandmarkSights* sights = Find(landmark);
      if (sights == nullptr) continue;
      for (const LandmarkSights::Seen& seen : sights->seen) ++shared[seen.keyframe];
    }
    std::tuple<int, bool> best = {options_.min_shared, false};
    KeyframeId stand_in;
    for (const auto& [other, count] : shared) {
      const std::tuple<int, bool> rank = {count, other.local_map == id.local_map};
      if (other == id || gone_.contains(other) || rank < best || !HasSameUnits(id, other)) continue;
      if (stand_in.IsValid() && rank == best) continue;
      best = rank;
      stand_in = other;
    }
    return stand_in;
  }

  bool HasSameUnits(KeyframeId a, KeyframeId b) const {
    const double ratio = view_.poses.at(a).scale / view_.poses.at(b).scale;
    return std::abs(ratio - 1) <= kSameUnits;
  }

  std::optional<RetiredKeyframe> Describe(KeyframeId id) const {
    const auto parent = ParentOf(id);
    const KeyframeId stand_in = FindStandIn(id);
    if (!parent.has_value() || !stand_in.IsValid()) return std::nullopt;
    const Similarity3d relative = view_.poses.at(stand_in) * view_.poses.at(id).Inverse();
    return RetiredKeyframe{id,
                           parent->first,
                           parent->second,
                           {stand_in, Rigid3d{relative.rotation, relative.translation}}};
  }

  // Returns the nearest ancestor that stays, and its pose of the keyframe in the local layer;
  // nullopt where the view doesn't reach so far.
  std::optional<std::pair<KeyframeId, Rigid3d>> ParentOf(KeyframeId id) const {
    KeyframeId parent = view_.parents.at(id);
    while (gone_.contains(parent)) parent = view_.parents.at(parent);
    const auto pose = view_.local_poses.find(parent);
    if (pose == view_.local_poses.end()) return std::nullopt;
    return std::pair(parent, pose->second * view_.local_poses.at(id).Inverse());
  }

  const RetiringView& view_;
  const SightsOfLandmarks& sights_;
  const absl::flat_hash_set<MapPointId>& faded_;
  const ChoiceOptions& options_;
  SessionLinks links_;
  std::vector<KeyframeId> going_;
  absl::flat_hash_set<KeyframeId> gone_;
};

}  // namespace

std::vector<RetiredKeyframe> ChooseKeyframes(const RetiringView& view,
                                             const SightsOfLandmarks& sights,
                                             const absl::flat_hash_set<MapPointId>& faded,
                                             const ChoiceOptions& options) {
  return Choice(view, sights, faded, options).Run();
}

}  // namespace corbslam::map_store
