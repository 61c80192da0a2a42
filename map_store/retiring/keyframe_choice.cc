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
    order.reserve(ranked.size());
    for (const auto& [holds, session, share, id] : ranked) order.push_back(id);
    return order;
  }

  struct Worth {
    int landmarks = 0;
    int seen = 0;      // By enough others.
    int homeless = 0;  // Without it.
  };

  bool MayGo(KeyframeId id) const {
    const Worth worth = WorthOf(*view_.map.FindKeyframe(id));
    return worth.landmarks > 0 && worth.seen >= options_.seen_share * worth.landmarks &&
           worth.homeless <= options_.max_homeless_share * worth.landmarks &&
           !links_.IsNeeded(id) && FindStandIn(id).IsValid();
  }

  // Returns the share of the landmarks that it observes of which enough others see.
  double SeenShare(const Keyframe& keyframe) const {
    const Worth worth = WorthOf(keyframe);
    return worth.landmarks == 0 ? 0 : static_cast<double>(worth.seen) / worth.landmarks;
  }

  Worth WorthOf(const Keyframe& keyframe) const {
    Worth worth;
    for (uint32_t i = 0; i < keyframe.points.size(); ++i) {
      const LandmarkSights* sights = Find(keyframe.points[i]);
      if (sights == nullptr) continue;
      ++worth.landmarks;
      Judge(keyframe.points[i], *sights, keyframe.id(), keyframe.keypoints()[i].octave, worth);
    }
    return worth;
  }

  const LandmarkSights* Find(MapPointId landmark) const {
    if (!landmark.IsValid() || faded_.contains(landmark)) return nullptr;
    const auto it = sights_.find(landmark);
    return it == sights_.end() ? nullptr : &it->second;
  }

  void Judge(MapPointId landmark, const LandmarkSights& sights, KeyframeId by, int octave,
             Worth& worth) const {
    int others = 0;
    bool observed = false;
    bool at_home = false;
    for (const LandmarkSights::Seen& seen : sights.seen) {
      if (seen.keyframe == by || gone_.contains(seen.keyframe)) continue;
      others += seen.octave <= octave + kOctaveSlack;
      observed = observed || seen.observed;
      at_home = at_home || (seen.observed && IsAtHome(landmark, seen.keyframe.local_map));
    }
    for (const auto& [keyframe, keypoint] : view_.map.FindPoint(landmark)->observations) {
      if (view_.closed.contains(keyframe.local_map)) continue;
      observed = true;
      at_home = at_home || IsAtHome(landmark, keyframe.local_map);
    }
    worth.seen += others >= options_.min_others;
    worth.homeless += observed && !at_home;
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
