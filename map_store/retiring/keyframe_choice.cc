#include "map_store/retiring/keyframe_choice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "map_store/retiring/local_map_links.h"

namespace corbslam::map_store {
namespace {

constexpr int kOctaveSlack = 1;
// Poses relative to a stand-in are rigid: where units differ by more than this share, it is none.
constexpr double kSameUnits = 0.01;

class Choice {
 public:
  Choice(const RetiringView& view, const SightsOfLandmarks& sights,
         const absl::flat_hash_set<MapPointId>& faded, const ChoiceOptions& options)
      : view_(view),
        sights_(sights),
        faded_(faded),
        options_(options),
        other_visits_(FindOtherVisits(view, options.other_visits)),
        links_(view.overlaps) {}

  std::vector<RetiredKeyframe> Run() {
    for (const KeyframeId& id : OrderByAge()) {
      if (Judge(id) == Verdict::kGoes) LetGo(id);
    }
    for (const KeyframeId& id : OrderByShare()) {
      if (Judge(id) == Verdict::kGoes) LetGo(id);
    }
    std::vector<RetiredKeyframe> retired;
    for (const KeyframeId& id : going_) {
      if (auto one = Describe(id)) retired.push_back(*std::move(one));
    }
    return retired;
  }

  StayCounts CountStays() const {
    StayCounts counts;
    for (const KeyframeId& id : view_.candidates) {
      if (gone_.contains(id) || view_.map.FindKeyframe(id) == nullptr) continue;
      const Verdict verdict = IsFirst(id) ? Verdict::kRoot : Judge(id);
      counts.roots += verdict == Verdict::kRoot;
      counts.newest += verdict == Verdict::kNewest;
      counts.links += verdict == Verdict::kLinks;
      counts.homeless += verdict == Verdict::kHomeless;
      counts.unseen += verdict == Verdict::kUnseen;
      counts.unplaced += verdict == Verdict::kUnplaced || verdict == Verdict::kGoes;
    }
    return counts;
  }

 private:
  enum class Verdict { kGoes, kRoot, kNewest, kLinks, kHomeless, kUnseen, kUnplaced };

  struct Rank {
    bool holds = false;
    size_t session = 0;
    double share = 0;
    KeyframeId id;
  };

  // Returns whether the keyframe is a local map's first one, and the local map no part of another.
  bool IsFirst(KeyframeId id) const {
    return !view_.parents.contains(id) && view_.closed.at(id.local_map).whole == id.local_map;
  }

  // Returns whether nothing else is left of a part, which has nothing to be held to others then.
  bool IsLast(KeyframeId id) const {
    const RetiringView::Closed& closed = view_.closed.at(id.local_map);
    const auto gone = gone_of_.find(id.local_map);
    const size_t left = closed.keyframes - (gone == gone_of_.end() ? 0 : gone->second);
    return closed.whole != id.local_map && left == 1;
  }

  void LetGo(KeyframeId id) {
    going_.push_back(id);
    gone_.insert(id);
    ++gone_of_[id.local_map];
    links_.Cut(id);
  }

  std::vector<Rank> RankAll() const {
    std::vector<Rank> ranks;
    for (const KeyframeId& id : view_.candidates) {
      const Keyframe* keyframe = view_.map.FindKeyframe(id);
      if (keyframe == nullptr || IsFirst(id) || gone_.contains(id)) continue;
      ranks.push_back(
          {links_.Holds(id), view_.closed.at(id.local_map).order, SeenShare(*keyframe), id});
    }
    return ranks;
  }

  template <typename Key>
  static std::vector<KeyframeId> Sorted(std::vector<Rank> ranks, const Key& key) {
    std::sort(ranks.begin(), ranks.end(),
              [&key](const Rank& a, const Rank& b) { return key(a) < key(b); });
    std::vector<KeyframeId> order;
    order.reserve(ranks.size());
    for (const Rank& rank : ranks) order.push_back(rank.id);
    return order;
  }

  std::vector<KeyframeId> OrderByAge() const {
    return Sorted(RankAll(), [](const Rank& rank) {
      return std::tuple(rank.holds, rank.session, -rank.share, rank.id);
    });
  }

  // Returns those at whose places there are enough other visits.
  std::vector<KeyframeId> OrderByShare() const {
    std::vector<Rank> ranks = RankAll();
    std::erase_if(ranks, [this](const Rank& rank) { return !IsVisitedEnough(rank.id); });
    return Sorted(std::move(ranks), [](const Rank& rank) {
      return std::tuple(rank.holds, -rank.share, rank.session, rank.id);
    });
  }

  struct Worth {
    int landmarks = 0;
    int seen = 0;      // By enough others.
    int homeless = 0;  // Without it.
  };

  Verdict Judge(KeyframeId id) const {
    const std::map<KeyframeId, int> shared = CountShared(id);
    if (!IsSeenLater(id, shared)) return Verdict::kNewest;
    if (!IsLast(id) && links_.IsNeeded(id)) return Verdict::kLinks;
    const bool is_visited_enough = IsVisitedEnough(id);
    const Worth worth = WorthOf(*view_.map.FindKeyframe(id));
    const double max_homeless =
        is_visited_enough ? options_.max_homeless_share_where_visited : options_.max_homeless_share;
    if (worth.homeless > max_homeless * worth.landmarks) return Verdict::kHomeless;
    const bool is_seen = worth.landmarks > 0 && worth.seen >= options_.seen_share * worth.landmarks;
    if (!is_seen && !is_visited_enough) return Verdict::kUnseen;
    return FindStandIn(id, shared).IsValid() ? Verdict::kGoes : Verdict::kUnplaced;
  }

  // Returns the keyframes that stay and look at its place.
  std::vector<KeyframeId> OtherVisitsOf(KeyframeId id) const {
    const auto it = other_visits_.find(id);
    if (it == other_visits_.end()) return {};
    std::vector<KeyframeId> other_visits = it->second;
    std::erase_if(other_visits, [this](KeyframeId other) { return gone_.contains(other); });
    return other_visits;
  }

  bool IsVisitedEnough(KeyframeId id) const {
    std::set<LocalMapId> visits;
    for (const KeyframeId& other : OtherVisitsOf(id)) visits.insert(other.local_map);
    return visits.size() >= options_.max_visits;
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
      Weigh(keyframe.points[i], *sights, keyframe.id(), keyframe.keypoints()[i].octave, worth);
    }
    return worth;
  }

  const LandmarkSights* Find(MapPointId landmark) const {
    if (!landmark.IsValid() || faded_.contains(landmark)) return nullptr;
    const auto it = sights_.find(landmark);
    return it == sights_.end() ? nullptr : &it->second;
  }

  void Weigh(MapPointId landmark, const LandmarkSights& sights, KeyframeId by, int octave,
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

  // Returns how many of the landmarks that it observes each keyframe sees that stays.
  std::map<KeyframeId, int> CountShared(KeyframeId id) const {
    std::map<KeyframeId, int> shared;
    for (const MapPointId& landmark : view_.map.FindKeyframe(id)->points) {
      const LandmarkSights* sights = Find(landmark);
      if (sights == nullptr) continue;
      for (const LandmarkSights::Seen& seen : sights->seen) {
        if (seen.keyframe != id && !gone_.contains(seen.keyframe)) ++shared[seen.keyframe];
      }
    }
    return shared;
  }

  // Returns whether a later local map sees the place, in whatever light.
  bool IsSeenLater(KeyframeId id, const std::map<KeyframeId, int>& shared) const {
    const auto is_later = [this, id](KeyframeId other) {
      return view_.closed.at(other.local_map).order > view_.closed.at(id.local_map).order;
    };
    return std::ranges::any_of(OtherVisitsOf(id), is_later) ||
           std::ranges::any_of(shared, [&](const auto& other) {
             return other.second >= options_.min_shared && is_later(other.first);
           });
  }

  // Returns the keyframe that stays and sees most of what this one observes; of those that see as
  // much, one of its own local map, then the least. Invalid: none sees enough.
  KeyframeId FindStandIn(KeyframeId id, const std::map<KeyframeId, int>& shared) const {
    std::tuple<int, bool> best = {options_.min_shared, false};
    KeyframeId stand_in;
    for (const auto& [other, count] : shared) {
      const std::tuple<int, bool> rank = {count, other.local_map == id.local_map};
      if (rank < best || !HasSameUnits(id, other)) continue;
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
    const KeyframeId stand_in = FindStandIn(id, CountShared(id));
    if (!parent.has_value() || !stand_in.IsValid()) return std::nullopt;
    const Similarity3d relative = view_.poses.at(stand_in) * view_.poses.at(id).Inverse();
    return RetiredKeyframe{id,
                           parent->first,
                           parent->second,
                           {stand_in, Rigid3d{relative.rotation, relative.translation}}};
  }

  // Returns what stays and what poses relative to the keyframe become relative to: the nearest
  // ancestor, or, where a part's first one has gone, too, the one of the whole that sees most of
  // what the keyframe observes. Nullopt where the view doesn't reach so far.
  std::optional<std::pair<KeyframeId, Rigid3d>> ParentOf(KeyframeId id) const {
    KeyframeId parent = id;
    do {
      const auto next = view_.parents.find(parent);
      parent = next == view_.parents.end() ? FindNeighbour(id) : next->second;
    } while (gone_.contains(parent));
    const auto pose = view_.local_poses.find(parent);
    if (pose == view_.local_poses.end()) return std::nullopt;
    return std::pair(parent, pose->second * view_.local_poses.at(id).Inverse());
  }

  // Returns the keyframe of the same local map, parts and all, that stays and sees most of what
  // this one observes. Invalid: none sees enough.
  KeyframeId FindNeighbour(KeyframeId id) const {
    const LocalMapId whole = view_.closed.at(id.local_map).whole;
    std::pair<int, KeyframeId> best = {options_.min_shared - 1, KeyframeId()};
    for (const auto& [other, count] : CountShared(id)) {
      const bool is_own = view_.closed.at(other.local_map).whole == whole;
      if (is_own && count > best.first) best = {count, other};
    }
    return best.second;
  }

  const RetiringView& view_;
  const SightsOfLandmarks& sights_;
  const absl::flat_hash_set<MapPointId>& faded_;
  const ChoiceOptions& options_;
  const OtherVisits other_visits_;
  LocalMapLinks links_;
  std::vector<KeyframeId> going_;
  absl::flat_hash_set<KeyframeId> gone_;
  absl::flat_hash_map<LocalMapId, size_t> gone_of_;
};

}  // namespace

std::vector<RetiredKeyframe> ChooseKeyframes(const RetiringView& view,
                                             const SightsOfLandmarks& sights,
                                             const absl::flat_hash_set<MapPointId>& faded,
                                             const ChoiceOptions& options, StayCounts* stays) {
  Choice choice(view, sights, faded, options);
  std::vector<RetiredKeyframe> retired = choice.Run();
  if (stays != nullptr) *stays = choice.CountStays();
  return retired;
}

std::string ToString(const StayCounts& counts) {
  return absl::StrCat(counts.roots, " roots, ", counts.newest, " newest, ", counts.links,
                      " that join local maps, ", counts.homeless, " with points of their own, ",
                      counts.unseen, " unseen, ", counts.unplaced, " without stand-in");
}

}  // namespace corbslam::map_store
