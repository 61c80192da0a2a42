// Implements the part of PostgresJournal that tells other stores how much this one has to do, and
// finds what goes to them when that is too much.
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_join.h"
#include "map_store/fleet/balance.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/postgres/postgres_mission.h"
#include "map_store/postgres/sql_pool.h"

namespace corbslam::map_store {
namespace {

// What somebody else began to be meanwhile stays so. The load counts as long as it is said with the
// lease, which older programs prolong alone.
constexpr char kSayAlive[] =
    "INSERT INTO corbslam.stores (name, holder, address, machine, version, lease_until, load_until,"
    " busy_milli, processors_milli, resident_bytes, budget_bytes, keyframes_milli,"
    " waiting_requests, workers) SELECT $1, $2, $3, $4, $5, said.until, said.until, $7, $8, $9,"
    " $10, $11, $12, $13 FROM (SELECT clock_timestamp() + $6 * interval '1 millisecond' AS until)"
    " AS said ON CONFLICT (name) DO UPDATE SET lease_until = excluded.lease_until,"
    " load_until = excluded.load_until, busy_milli = excluded.busy_milli,"
    " processors_milli = excluded.processors_milli, resident_bytes = excluded.resident_bytes,"
    " budget_bytes = excluded.budget_bytes, keyframes_milli = excluded.keyframes_milli,"
    " waiting_requests = excluded.waiting_requests, workers = excluded.workers"
    " WHERE stores.holder = excluded.holder RETURNING cordoned";

SqlValue Milli(double number) {
  return SqlValue::Number(static_cast<int64_t>(std::llround(number * 1e3)));
}

}  // namespace

SqlStatement PostgresJournal::SayAlive(const DirectoryStore& self) const {
  const StoreLoad load = self.load.value_or(StoreLoad());
  return {kSayAlive,
          {SqlValue::Text(self.name), SqlValue::Number(holder_.id), SqlValue::Text(self.address),
           SqlValue::Text(self.machine), SqlValue::Text(self.version), holder_.LeaseMilliseconds(),
           self.load.has_value() ? Milli(load.busy_processors) : SqlValue::NoNumber(),
           Milli(load.processors), SqlValue::Bits(load.resident_bytes),
           SqlValue::Bits(load.budget_bytes), Milli(load.keyframes_per_s),
           SqlValue::Bits(self.waiting_requests),
           SqlValue::Text(absl::StrJoin(options_.workers, ","))}};
}

void PostgresJournal::NoteLoad(const WeighedStore& load) {
  absl::MutexLock lock(&mutex_);
  self_.load = load.load;
  self_.waiting_requests = load.waiting_requests;
  weights_ = load.missions;
}

std::map<std::string, DirectoryStore> PostgresJournal::FindBalancingMove(
    const std::vector<MissionPtr>& held, const DirectoryStore& self, const Renewed& renewed,
    const std::vector<DirectoryStore>& stores) const {
  const std::vector<BalancePair> pairs = PairStores(stores, options_.balance);
  const auto pair = std::find_if(pairs.begin(), pairs.end(), [&self](const BalancePair& one) {
    return one.giver == self.name;
  });
  if (pair == pairs.end()) return {};
  const auto find_store = [&stores](const std::string& name) {
    return *std::find_if(stores.begin(), stores.end(),
                         [&name](const DirectoryStore& store) { return store.name == name; });
  };
  const DirectoryStore taker = find_store(pair->taker);
  std::vector<HeldMission> missions;
  {
    absl::MutexLock lock(&mutex_);
    for (const MissionPtr& mission : held) {
      const auto weight = weights_.find(mission->name());
      if (weight == weights_.end() || renewed.wanted.count(mission->id()) == 0) continue;
      const auto moved = renewed.since_moved.find(mission->id());
      missions.push_back(
          {mission->name(), weight->second,
           moved == renewed.since_moved.end() ? absl::InfiniteDuration() : moved->second});
    }
  }
  const StoreLoad own = *find_store(self.name).load;
  const HeldMission* chosen = ChooseMission(missions, own, *taker.load, options_.balance);
  if (chosen == nullptr) return {};
  const absl::StatusOr<bool> begun =
      fleet_.BeginBalancing(self.name, taker.name, options_.balance.store_rests);
  LOG_IF(WARNING, !begun.ok()) << "loads are not balanced: " << begun.status();
  if (!begun.ok() || !*begun) return {};
  LOG(INFO) << "mission " << chosen->name << " is to balance loads: this store's is "
            << own.Pressure() << ", that of " << taker.name << " is " << taker.load->Pressure();
  return {{chosen->name, taker}};
}

void PostgresJournal::CountStandbys() {
  const absl::StatusOr<StandbyCounts> counted = fleet_.CountStandbys();
  absl::MutexLock lock(&mutex_);
  counts_.standbys = counted.ok() ? std::optional(*counted) : std::nullopt;
}

FleetCounts PostgresJournal::counts() const {
  absl::MutexLock lock(&mutex_);
  FleetCounts counts = counts_;
  counts.refused_writes = *holder_.refused;
  counts.busy_pool = pool_->times_busy();
  counts.load = self_.load;
  return counts;
}

}  // namespace corbslam::map_store
