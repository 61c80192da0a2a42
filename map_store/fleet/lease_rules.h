// Who has a mission, who may take it and where it goes: what follows from the directory, without
// any clock, database or store of its own. The journal on a database and the simulation of fleets
// (tests/bench/fleet_simulation.cc) both ask here.
#ifndef CORBSLAM_MAP_STORE_FLEET_LEASE_RULES_H_
#define CORBSLAM_MAP_STORE_FLEET_LEASE_RULES_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "map_store/fleet/directory.h"

namespace corbslam::map_store {

// Who has a mission, as its row says.
struct MissionHolding {
  int64_t holder = 0;                                // The process's number.
  int64_t epoch = 0;                                 // How often it was taken.
  absl::Duration lease_left = absl::ZeroDuration();  // By the database's clock.
};

// Returns whether the process `own` may take the mission, in the next epoch.
inline bool MayTake(const MissionHolding& row, int64_t own) {
  return row.holder == own || row.lease_left <= absl::ZeroDuration();
}

// Returns whether who took the mission in `epoch` may write into it: nobody has taken it since. How
// long the lease is does not matter.
inline bool MayWrite(const MissionHolding& row, int64_t epoch) { return row.epoch == epoch; }

// Knows by the process's own clock until when nobody else takes what it has. It ends before the
// database's lease does, as long as the process's clock is slower than the database's by less than
// a tenth.
class OwnLease {
 public:
  OwnLease(absl::Duration lease, absl::Time now) : lease_(lease) { NoteProlonged(now); }

  // Notes that the leases were prolonged, at the database some time after `asked`, when the request
  // was made.
  void NoteProlonged(absl::Time asked) { until_ = asked + lease_ * 9 / 10; }
  bool IsOver(absl::Time now) const { return now >= until_; }
  // Returns how long after one request to prolong leases the next one is made.
  absl::Duration between_requests() const { return lease_ / 3; }

 private:
  const absl::Duration lease_;
  absl::Time until_;
};

// Of the stores that are alive and take missions, this process's aside, returns the one that has
// the fewest; null: there is none.
const DirectoryStore* FindFreest(const std::vector<DirectoryStore>& stores);

// Returns the store that is to take a mission, which nobody has, instead of this one; null: this
// one takes it. `wanted` is the store that it was moved to, by its name, or empty.
const DirectoryStore* FindTaker(StoreDuty own_duty, const std::string& wanted,
                                const std::vector<DirectoryStore>& stores);

// Returns where missions of the store `own` are to go: those that were moved, and all of one that
// is drained. `held` has the missions, each with the store that is to have it, or with nothing.
std::map<std::string, DirectoryStore> PlanMoves(const std::string& own, StoreDuty own_duty,
                                                const std::map<std::string, std::string>& held,
                                                std::vector<DirectoryStore> stores);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FLEET_LEASE_RULES_H_
