#include "map_store/fleet/balance.h"

#include <algorithm>
#include <cstddef>

namespace corbslam::map_store {
namespace {

StoreLoad With(StoreLoad load, const MissionWeight& weight) {
  load.busy_processors += weight.busy_processors;
  load.resident_bytes += weight.bytes;
  return load;
}

StoreLoad Without(StoreLoad load, const MissionWeight& weight) {
  load.busy_processors = std::max(0.0, load.busy_processors - weight.busy_processors);
  load.resident_bytes -= std::min(load.resident_bytes, weight.bytes);
  return load;
}

}  // namespace

std::vector<BalancePair> PairStores(const std::vector<DirectoryStore>& stores,
                                    const BalanceRules& rules) {
  if (rules.above <= 0) return {};
  std::vector<const DirectoryStore*> by_pressure;
  for (const DirectoryStore& store : stores) {
    if (store.IsAlive() && !store.is_cordoned && store.load.has_value() &&
        store.since_balanced >= rules.store_rests) {
      by_pressure.push_back(&store);
    }
  }
  std::sort(by_pressure.begin(), by_pressure.end(), [](const auto* a, const auto* b) {
    const double of_a = a->load->Pressure();
    const double of_b = b->load->Pressure();
    return of_a != of_b ? of_a < of_b : a->name < b->name;
  });
  std::vector<BalancePair> pairs;
  for (size_t low = 0, high = by_pressure.size(); low + 1 < high; ++low) {
    const DirectoryStore& taker = *by_pressure[low];
    const DirectoryStore& giver = *by_pressure[--high];
    const double pressure = giver.load->Pressure();
    if (pressure <= rules.above || pressure - taker.load->Pressure() <= rules.least_gap) break;
    pairs.push_back({giver.name, taker.name});
  }
  return pairs;
}

const HeldMission* ChooseMission(const std::vector<HeldMission>& held, const StoreLoad& giver,
                                 const StoreLoad& taker, const BalanceRules& rules) {
  const HeldMission* best = nullptr;
  double lightest = giver.Pressure();
  for (const HeldMission& mission : held) {
    if (mission.since_moved < rules.mission_stays) continue;
    const double left = Without(giver, mission.weight).Pressure();
    const double taken = With(taker, mission.weight).Pressure();
    if (taken > left || taken > rules.above || left >= lightest) continue;
    lightest = left;
    best = &mission;
  }
  return best;
}

}  // namespace corbslam::map_store
