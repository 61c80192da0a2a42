// Plays a simulated fleet (fleet_simulation.h). Robots, stores and databases send each other
// messages that take time, are late where a store is paused, and get lost where a way is cut.
#ifndef CORBSLAM_TESTS_BENCH_FLEET_ENGINE_H_
#define CORBSLAM_TESTS_BENCH_FLEET_ENGINE_H_

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/bench/fleet_simulation.h"
#include "tests/bench/fleet_world.h"

namespace corbslam::tests {

// One thread uses it, once.
class FleetEngine {
 public:
  explicit FleetEngine(const FleetOptions& options);
  FleetResult Run();

 private:
  using Facts = Timeline<FleetEngine>::Facts;
  using Happens = Timeline<FleetEngine>::Happens;

  // Robots (fleet_engine_robots.cc). Facts: a robot, b turn, c store, d batch; e process.
  void Attempt(const Facts& facts);
  void ArriveAtStore(const Facts& facts);
  void SendBatch(const Facts& facts);
  void TakeBatch(const Facts& facts);
  void SendAppend(const Facts& facts);
  void Append(const Facts& facts);
  void NoteAppended(const Facts& facts);
  void FailAppend(const Facts& facts);
  void Acknowledge(const Facts& facts);
  void LoseLine(const Facts& facts);
  void Fail(uint32_t robot);
  void Redirect(uint32_t robot, uint32_t store);
  void OpenSession(uint32_t robot, uint32_t store, const LoadedMission& loaded);

  // Missions (fleet_engine_missions.cc). Facts: c store, d mission; e process, f epoch.
  void Look(const Facts& facts);
  void Take(const Facts& facts);
  void NoteTaken(const Facts& facts);
  void NoteElsewhere(const Facts& facts);  // b: where it is; nobody: the database was not reached.
  void NoteLoaded(const Facts& facts);
  void Release(const Facts& facts);  // a: 1 to balance loads; b: the store that is to have it.
  void NoteReleased(const Facts& facts);
  void LoseMission(uint32_t store, uint32_t mission, uint32_t to);
  void GiveAway(uint32_t store, uint32_t mission, uint32_t to, bool balances);

  // Leases (fleet_engine_leases.cc). Facts: c store; e process, f when it was asked.
  void AskToProlong(const Facts& facts);
  void Prolong(const Facts& facts);
  void NoteProlonged(const Facts& facts);
  void ListForBalance(const Facts& facts);
  void BeginBalancing(const Facts& facts);
  void Announce(const Facts& facts);
  std::vector<map_store::DirectoryStore> ListStores(uint32_t database, uint32_t own) const;
  void PlanAll(uint32_t store);
  void Meter(uint32_t store);

  // What goes wrong (fleet_engine_faults.cc). Facts: c store or database.
  void HappenAtRandom(const Facts& facts);  // c: database.
  void Kill(uint32_t store);
  void Restart(const Facts& facts);
  void Pause(uint32_t store, Nanos length);
  void NotePause(const Facts& facts);
  void Resume(const Facts& facts);
  void CutFromDatabase(uint32_t store, Nanos length);
  void MendToDatabase(const Facts& facts);
  void CutFromRobots(uint32_t store, Nanos length);
  void MendToRobots(const Facts& facts);
  void StopDatabase(uint32_t database, Nanos length);
  void StartDatabase(const Facts& facts);
  void SetDuty(uint32_t store, map_store::StoreDuty duty);
  void Uncordon(const Facts& facts);
  void StrikeDisaster(const Facts& facts);
  void BreakSessions(uint32_t store, Nanos later);

  // Times.
  Nanos now() const { return timeline_.now(); }
  Nanos DatabaseNow(uint32_t database) const { return now() + databases_[database].clock_ahead; }
  absl::Time OwnNow(const SimulatedStore& store) const;
  Nanos Way() { return Between(absl::Microseconds(200), absl::Milliseconds(3)); }
  Nanos RobotsWay() { return Between(absl::Milliseconds(2), absl::Milliseconds(60)); }
  Nanos Between(absl::Duration least, absl::Duration most);
  bool Chance(double probability) { return std::bernoulli_distribution(probability)(random_); }
  void After(Nanos wait, Happens happens, const Facts& facts) {
    timeline_.At(now() + wait, happens, facts);
  }
  // Returns whether the store's process can do it now. If it is paused, it happens once it goes on;
  // if it is another process, never.
  bool IsForStore(Happens happens, const Facts& facts);
  bool IsReached(uint32_t store) const;  // The database, by the store.
  bool Refuses(const SimulatedStore& store) const;

  // Places.
  uint32_t DatabaseOf(uint32_t store) const { return store / stores_each_; }
  uint32_t MissionOf(uint32_t robot) const { return robot / robots_each_; }
  uint32_t DatabaseOfMission(uint32_t mission) const { return mission / missions_each_; }
  uint32_t StoreOf(int64_t process) const {
    return process == 0 ? kNobody : processes_[static_cast<size_t>(process)];
  }
  std::string NameOf(uint32_t store) const { return "s" + std::to_string(store); }
  uint32_t StoreNamed(const std::string& name) const {
    return static_cast<uint32_t>(std::stoul(name.substr(1)));
  }

  // Counts, and what must not be.
  SimulatedDatabase& Counting(uint32_t database);
  void CountStatements(uint32_t database, uint64_t statements);
  void NoteChange(uint32_t database) { databases_[database].changed_at = now(); }
  bool IsHealthy(uint32_t database) const;
  Nanos Bound(uint32_t database) const;
  void CheckServed(uint32_t mission);
  void NoteServed(uint32_t mission);
  void Violate(const std::string& what);
  void Finish();

  const FleetOptions options_;
  const uint32_t stores_each_;
  const uint32_t missions_each_;
  const uint32_t robots_each_;
  std::mt19937_64 random_;
  Timeline<FleetEngine> timeline_;
  std::vector<SimulatedDatabase> databases_;
  std::vector<SimulatedStore> stores_;
  std::vector<SimulatedMission> missions_;
  std::vector<SimulatedRobot> robots_;
  std::vector<uint32_t> processes_;  // The store of each.
  std::vector<float> interruptions_s_;
  std::vector<Nanos> hit_at_;  // Of missions that a disaster hit; kNever: it did not, or is over.
  std::vector<float> served_after_s_;
  uint64_t calm_statements_ = 0;
  uint64_t calm_appends_ = 0;
  bool ends_ = false;  // Nothing goes wrong any more.
  FleetResult result_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_FLEET_ENGINE_H_
