// Which missions go from busy stores to others, so that none has much more to do than the rest.
#ifndef CORBSLAM_MAP_STORE_FLEET_BALANCE_H_
#define CORBSLAM_MAP_STORE_FLEET_BALANCE_H_

#include <map>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "map_store/fleet/directory.h"

namespace corbslam::map_store {

struct BalanceRules {
  // A store whose pressure (StoreLoad) is higher gives missions away; 0: none does.
  double above = 0.7;
  // Only to a store whose pressure is lower than its own by more than this.
  double least_gap = 0.2;
  // After a mission has come or gone, a store's load says nothing of that for so long: it takes
  // part in no other move.
  absl::Duration store_rests = absl::Minutes(1);
  // So long a mission stays where it came to.
  absl::Duration mission_stays = absl::Minutes(10);
};

// Of stores of the directory.
struct BalancePair {
  std::string giver;
  std::string taker;
  friend bool operator==(const BalancePair&, const BalancePair&) = default;
};

// Returns which stores are to give a mission to which now: the busiest to the least busy, and so
// on, each in one pair at most. Every store that reads the same directory finds the same pairs.
// Stores that are gone, cordoned or drained, and those that don't say how busy they are, are in
// none.
std::vector<BalancePair> PairStores(const std::vector<DirectoryStore>& stores,
                                    const BalanceRules& rules);

// A mission of a giver.
struct HeldMission {
  std::string name;
  MissionWeight weight;
  absl::Duration since_moved = absl::InfiniteDuration();  // To the store that has it.
};

// Returns the mission that goes from the giver to the taker: the heaviest of those with which the
// taker has not more to do than the giver without, and not too much; null: there is none.
const HeldMission* ChooseMission(const std::vector<HeldMission>& held, const StoreLoad& giver,
                                 const StoreLoad& taker, const BalanceRules& rules);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FLEET_BALANCE_H_
