// Implements the part of FleetEngine that is about leases, and about stores that have too much to
// do.
#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "tests/bench/fleet_engine.h"

namespace corbslam::tests {

using map_store::BalancePair;
using map_store::DirectoryStore;
using map_store::HeldMission;
using map_store::StoreDuty;

namespace {

constexpr double kProcessors = 4;

}  // namespace

std::vector<DirectoryStore> FleetEngine::ListStores(uint32_t database, uint32_t own) const {
  std::vector<DirectoryStore> listed;
  const Nanos clock = DatabaseNow(database);
  for (uint32_t i = database * stores_each_; i < (database + 1) * stores_each_; ++i) {
    const SimulatedStore& store = stores_[i];
    DirectoryStore row;
    row.name = NameOf(i);
    row.lease_left = absl::Nanoseconds(std::max<Nanos>(store.row_lease_until - clock, 0));
    row.is_cordoned = store.row_duty != StoreDuty::kTakesMissions;
    row.is_drained = store.row_duty == StoreDuty::kDrained;
    row.is_own = i == own;
    for (const uint32_t mission : store.row_missions) {
      row.missions +=
          missions_[mission].holder == store.row_holder && missions_[mission].lease_until > clock;
    }
    row.load = store.row_load;
    if (store.row_balanced_at != kNever) {
      row.since_balanced = absl::Nanoseconds(clock - store.row_balanced_at);
    }
    listed.push_back(std::move(row));
  }
  return listed;
}

void FleetEngine::Announce(const Facts& facts) {
  if (!IsForStore(&FleetEngine::Announce, facts)) return;
  SimulatedStore& store = stores_[facts.c];
  // A store that does not reach the database ends, and is started again.
  if (!IsReached(facts.c)) return After(kDatabaseTimeout, &FleetEngine::Announce, facts);
  const uint32_t database = DatabaseOf(facts.c);
  CountStatements(database, 3);
  const Nanos clock = DatabaseNow(database);
  for (const uint32_t mission : store.row_missions) {
    SimulatedMission& row = missions_[mission];
    if (row.holder == store.row_holder && row.holder != facts.e) row.lease_until = kNever;
  }
  store.row_missions.clear();
  store.row_holder = facts.e;
  store.row_lease_until = clock + absl::ToInt64Nanoseconds(options_.lease);
  store.row_load.reset();
  store.own_lease->NoteProlonged(OwnNow(store));
  After(Between(absl::ZeroDuration(), store.own_lease->between_requests()),
        &FleetEngine::AskToProlong, facts);
}

void FleetEngine::Meter(uint32_t at) {
  SimulatedStore& store = stores_[at];
  // What its missions' robots make it do, since it was metered last.
  double busy = 0.05;
  map_store::LoadMeter::Reading reading;
  for (const auto& [mission, loaded] : store.loaded) {
    if (loaded.stage != LoadedMission::Stage::kReady) continue;
    uint64_t keyframes = 0;
    for (const uint32_t known : loaded.known) keyframes += known;
    busy += missions_[mission].weight;
    reading.missions[std::to_string(mission)] = {keyframes, 1 << 20};
  }
  const double seconds = static_cast<double>(now() - store.metered_at) * 1e-9;
  store.metered_at = now();
  store.processor_s += std::min(busy, kProcessors) * seconds;
  reading.time = OwnNow(store);
  reading.processor_s = store.processor_s;
  reading.processors = kProcessors;
  store.weighed = store.meter.Note(reading);
}

void FleetEngine::AskToProlong(const Facts& facts) {
  if (!IsForStore(&FleetEngine::AskToProlong, facts)) return;
  SimulatedStore& store = stores_[facts.c];
  Meter(facts.c);
  Facts asked = facts;
  asked.f = absl::ToUnixNanos(OwnNow(store));
  const double wait =
      absl::ToDoubleSeconds(store.own_lease->between_requests()) * 1e9 / store.clock_rate;
  if (IsReached(facts.c)) {
    After(Way(), &FleetEngine::Prolong, asked);
    After(static_cast<Nanos>(wait), &FleetEngine::AskToProlong, facts);
  } else {
    // It tries for so long before it waits again.
    After(static_cast<Nanos>(wait) + kDatabaseTimeout, &FleetEngine::AskToProlong, facts);
  }
}

void FleetEngine::Prolong(const Facts& facts) {
  SimulatedStore& store = stores_[facts.c];
  if (!IsReached(facts.c)) return;
  const uint32_t database = DatabaseOf(facts.c);
  // The standbys are counted, too.
  CountStatements(database, 3);
  const Nanos until = DatabaseNow(database) + absl::ToInt64Nanoseconds(options_.lease);
  if (store.row_holder == facts.e) {
    std::erase_if(store.row_missions, [this, &facts](uint32_t mission) {
      return missions_[mission].holder != facts.e;
    });
    std::sort(store.row_missions.begin(), store.row_missions.end());
    store.row_missions.erase(std::unique(store.row_missions.begin(), store.row_missions.end()),
                             store.row_missions.end());
    for (const uint32_t mission : store.row_missions) missions_[mission].lease_until = until;
    store.row_lease_until = until;
    if (store.weighed.has_value()) store.row_load = store.weighed->load;
  }
  After(Way(), &FleetEngine::NoteProlonged, facts);
}

void FleetEngine::NoteProlonged(const Facts& facts) {
  if (!IsForStore(&FleetEngine::NoteProlonged, facts) || !IsReached(facts.c)) return;
  SimulatedStore& store = stores_[facts.c];
  // What it has lost, it drops before anything else: the lease of the rest is longer from then on.
  std::vector<std::pair<uint32_t, uint32_t>> lost;
  for (const auto& [mission, loaded] : store.loaded) {
    const SimulatedMission& row = missions_[mission];
    if (loaded.stage == LoadedMission::Stage::kReady && row.epoch != loaded.epoch) {
      lost.push_back({mission, StoreOf(row.holder)});
    }
  }
  std::sort(lost.begin(), lost.end());
  CountStatements(DatabaseOf(facts.c), lost.size());
  for (const auto& [mission, to] : lost) LoseMission(facts.c, mission, to);
  store.own_lease->NoteProlonged(absl::FromUnixNanos(facts.f));
  store.duty = store.row_duty;
  PlanAll(facts.c);
}

void FleetEngine::PlanAll(uint32_t at) {
  SimulatedStore& store = stores_[at];
  const bool drains = store.duty == StoreDuty::kDrained;
  const bool is_busy = options_.balance.above > 0 && store.weighed.has_value() &&
                       store.weighed->load.Pressure() > options_.balance.above;
  if (!drains && !is_busy) return;
  After(2 * Way(), &FleetEngine::ListForBalance, {.c = at, .e = store.process});
}

void FleetEngine::ListForBalance(const Facts& facts) {
  if (!IsForStore(&FleetEngine::ListForBalance, facts) || !IsReached(facts.c)) return;
  SimulatedStore& store = stores_[facts.c];
  const uint32_t database = DatabaseOf(facts.c);
  CountStatements(database, 1);
  const std::vector<DirectoryStore> listed = ListStores(database, facts.c);
  std::map<std::string, std::string> held;
  std::vector<HeldMission> weighed;
  for (const auto& [mission, loaded] : store.loaded) {
    if (loaded.stage != LoadedMission::Stage::kReady) continue;
    const std::string name = std::to_string(mission);
    held[name] = "";
    if (!store.weighed.has_value() || store.weighed->missions.count(name) == 0) continue;
    const Nanos moved = missions_[mission].moved_at;
    weighed.push_back({name, store.weighed->missions.at(name),
                       moved == kNever ? absl::InfiniteDuration()
                                       : absl::Nanoseconds(DatabaseNow(database) - moved)});
  }
  std::sort(weighed.begin(), weighed.end(),
            [](const HeldMission& a, const HeldMission& b) { return a.name < b.name; });
  for (const auto& [mission, to] :
       map_store::PlanMoves(NameOf(facts.c), store.duty, held, listed)) {
    GiveAway(facts.c, static_cast<uint32_t>(std::stoul(mission)), StoreNamed(to.name), false);
  }
  if (store.duty != StoreDuty::kTakesMissions) return;
  for (const BalancePair& pair : map_store::PairStores(listed, options_.balance)) {
    if (pair.giver != NameOf(facts.c)) continue;
    const uint32_t taker = StoreNamed(pair.taker);
    const HeldMission* chosen = map_store::ChooseMission(
        weighed, *store.row_load, *stores_[taker].row_load, options_.balance);
    if (chosen == nullptr) return;
    After(2 * Way(), &FleetEngine::BeginBalancing,
          {.b = taker,
           .c = facts.c,
           .d = static_cast<uint32_t>(std::stoul(chosen->name)),
           .e = facts.e});
  }
}

void FleetEngine::BeginBalancing(const Facts& facts) {
  if (!IsForStore(&FleetEngine::BeginBalancing, facts) || !IsReached(facts.c)) return;
  const uint32_t database = DatabaseOf(facts.c);
  CountStatements(database, 1);
  const Nanos clock = DatabaseNow(database);
  const Nanos rest = absl::ToInt64Nanoseconds(options_.balance.store_rests);
  for (const uint32_t at : {facts.b, facts.c}) {
    const SimulatedStore& row = stores_[at];
    const bool rests = row.row_balanced_at != kNever && row.row_balanced_at > clock - rest;
    if (rests || row.row_duty != StoreDuty::kTakesMissions || row.row_lease_until <= clock) return;
  }
  for (const uint32_t at : {facts.b, facts.c}) stores_[at].row_balanced_at = clock;
  GiveAway(facts.c, facts.d, facts.b, true);
}

}  // namespace corbslam::tests
