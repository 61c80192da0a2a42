#include "map_store/retiring/fading.h"

#include <algorithm>
#include <set>
#include <utility>

namespace corbslam::map_store {
namespace {

// How much a keyframe sees of what one other local map observes, 0 to 1; those of which it sees too
// little to say anything are not in it.
using Agreements = absl::flat_hash_map<std::pair<KeyframeId, LocalMapId>, double>;

struct Count {
  size_t seen = 0;
  size_t missed = 0;
};

std::set<LocalMapId> ObserversOf(const LandmarkSights& sights) {
  std::set<LocalMapId> observers;
  for (const LandmarkSights::Seen& seen : sights.seen) {
    if (seen.observed) observers.insert(seen.keyframe.local_map);
  }
  return observers;
}

Agreements FindAgreements(const SightsOfLandmarks& all, const FadingOptions& options) {
  absl::flat_hash_map<std::pair<KeyframeId, LocalMapId>, Count> counts;
  for (const auto& [id, sights] : all) {
    for (const LocalMapId& observer : ObserversOf(sights)) {
      for (const LandmarkSights::Seen& seen : sights.seen) {
        if (seen.keyframe.local_map != observer) ++counts[{seen.keyframe, observer}].seen;
      }
      for (const KeyframeId& keyframe : sights.missed_by) {
        if (keyframe.local_map != observer) ++counts[{keyframe, observer}].missed;
      }
    }
  }
  Agreements agreements;
  for (const auto& [pair, count] : counts) {
    const double agreement =
        static_cast<double>(count.seen) / static_cast<double>(count.seen + count.missed);
    if (count.seen < options.min_agreeing || agreement < options.min_agreement) continue;
    agreements[pair] = agreement;
  }
  return agreements;
}

// Returns how much the keyframe sees of what those see who observed the landmark; 0: too little.
double AgreementOf(KeyframeId keyframe, const std::set<LocalMapId>& observers,
                   const Agreements& agreements) {
  double most = 0;
  for (const LocalMapId& observer : observers) {
    const auto it = agreements.find({keyframe, observer});
    if (it != agreements.end()) most = std::max(most, it->second);
  }
  return most;
}

bool IsOfClosed(MapPointId landmark, const RetiringView& view) {
  const MapPoint* point = view.map.FindPoint(landmark);
  const auto members = view.landmarks.find(landmark);
  if (point == nullptr || members == view.landmarks.end()) return false;
  return std::ranges::all_of(
             members->second,
             [&view](MapPointId member) { return view.closed.contains(member.local_map); }) &&
         std::ranges::all_of(point->observations, [&view](const auto& seen) {
           return view.closed.contains(seen.first.local_map);
         });
}

bool HasVanished(const LandmarkSights& sights, const RetiringView& view,
                 const Agreements& agreements, const FadingOptions& options) {
  const auto order_of = [&view](KeyframeId id) { return view.closed.at(id.local_map).order; };
  size_t last = 0;
  for (const LandmarkSights::Seen& seen : sights.seen) {
    last = std::max(last, order_of(seen.keyframe));
  }
  const auto missed_then = static_cast<double>(
      std::ranges::count_if(sights.missed_by, [&](KeyframeId id) { return order_of(id) <= last; }));
  const auto seen = static_cast<double>(sights.seen.size());
  const double rate = seen / (seen + missed_then);
  const std::set<LocalMapId> observers = ObserversOf(sights);
  double chance = 1;
  size_t missed = 0;
  std::set<LocalMapId> local_maps;
  for (const KeyframeId& id : sights.missed_by) {
    if (order_of(id) <= last) continue;
    const double agreement = AgreementOf(id, observers, agreements);
    if (agreement == 0) continue;
    chance *= 1 - rate * agreement;
    ++missed;
    local_maps.insert(id.local_map);
  }
  return !sights.seen.empty() && missed >= options.min_missed &&
         local_maps.size() >= options.min_local_maps && chance <= options.max_chance;
}

}  // namespace

std::vector<MapPointId> FindFaded(const RetiringView& view, const SightsOfLandmarks& sights,
                                  const FadingOptions& options) {
  const Agreements agreements = FindAgreements(sights, options);
  std::vector<MapPointId> faded;
  for (const auto& [id, of_landmark] : sights) {
    if (!IsOfClosed(id, view)) continue;
    if (HasVanished(of_landmark, view, agreements, options)) faded.push_back(id);
  }
  return faded;
}

}  // namespace corbslam::map_store
