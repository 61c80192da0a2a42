// Simulates fleets of stores, databases, missions and robots under a virtual clock, with what goes
// wrong among them. What decides is the code that ships: who may take and write a mission
// (map_store/fleet/lease_rules.h), what a store has to do and what it gives away (load_meter.h,
// balance.h), and when robots try again (client_agent/link/backoff.h). What a database does with
// rows is modelled after the statements of map_store/postgres, one event each.
#ifndef CORBSLAM_TESTS_BENCH_FLEET_SIMULATION_H_
#define CORBSLAM_TESTS_BENCH_FLEET_SIMULATION_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "map_store/fleet/balance.h"

namespace corbslam::tests {

// What is done to a fleet besides what happens at random.
enum class Disaster { kNone, kLostRack, kLostDatabase, kHerd };

struct FleetOptions {
  uint64_t seed = 1;
  // Each database has as many stores and missions as the others, which have nothing to do with its
  // own.
  int databases = 1;
  int stores_per_database = 3;
  int missions_per_database = 12;
  int robots_per_mission = 2;
  absl::Duration lease = absl::Seconds(15);
  absl::Duration duration = absl::Minutes(5);
  // Without faults, at the end: all are to be served again.
  absl::Duration calm = absl::Minutes(2);
  // Of one robot: from an acknowledgement to its next batch.
  absl::Duration between_batches = absl::Seconds(2);
  // A store reads one mission after the other, each for so long.
  absl::Duration loading = absl::Milliseconds(300);
  // Of one database and its stores; infinite: nothing happens at random.
  absl::Duration between_faults = absl::Seconds(20);
  // By which a store's clock is faster or slower than the database's, at most.
  double clock_error = 0.05;
  map_store::BalanceRules balance = {};
  Disaster disaster = Disaster::kNone;
  absl::Time disaster_at = absl::UnixEpoch() + absl::Seconds(60);
  // False: as if a store opened sessions without looking whether its own lease is over. For tests
  // of the simulation itself.
  bool checks_own_lease = true;
  // False: as if the database took writes of any epoch. Likewise.
  bool checks_epoch = true;
};

struct FleetResult {
  // What must not be, with the time and the place; empty: nothing was.
  std::vector<std::string> violations;
  uint64_t events = 0;
  uint64_t acknowledged = 0;  // Batches.
  uint64_t faults = 0;
  uint64_t takes = 0;  // How often a store took a mission.
  uint64_t lost = 0;   // Missions that stores found to be another one's.
  uint64_t refused_writes = 0;
  uint64_t balancing_moves = 0;
  uint64_t drained_moves = 0;
  uint64_t redirects = 0;
  uint64_t attempts = 0;  // Of robots to open a session.
  // Statements at one database a second, besides those that append: over the calm beginning, and
  // the most of any second and database.
  double directory_statements = 0;
  uint64_t most_directory_statements = 0;
  double appends = 0;
  uint64_t most_appends = 0;
  uint64_t most_attempts = 0;  // Of robots of one database in a second.
  // How long missions that somebody wanted had nobody, seconds: of those longer than a batch takes.
  uint64_t interruptions = 0;
  double interruption_p50_s = 0;
  double interruption_p99_s = 0;
  double interruption_max_s = 0;
  // Seconds after a disaster until 99 % and all of the missions that it hit were served.
  double most_served_after_s = 0;
  double all_served_after_s = 0;
};

// The same options give the same result.
FleetResult SimulateFleet(const FleetOptions& options);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_FLEET_SIMULATION_H_
