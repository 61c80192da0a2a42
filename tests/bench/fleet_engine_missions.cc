// Implements the part of FleetEngine that is about missions: how stores take, lose and give them.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "tests/bench/fleet_engine.h"

namespace corbslam::tests {

using map_store::DirectoryStore;
using map_store::MissionHolding;

namespace {

// The store's keeper of leases looks so often.
constexpr absl::Duration kBetweenLooks = absl::Milliseconds(250);

absl::Duration Left(Nanos until, Nanos now) {
  return until <= now ? absl::ZeroDuration() : absl::Nanoseconds(until - now);
}

}  // namespace

void FleetEngine::Look(const Facts& facts) {
  if (!IsReached(facts.c)) {
    return After(kDatabaseTimeout, &FleetEngine::NoteElsewhere,
                 {.b = kNobody, .c = facts.c, .d = facts.d, .e = facts.e});
  }
  const uint32_t database = DatabaseOf(facts.c);
  CountStatements(database, 1);
  const SimulatedMission& row = missions_[facts.d];
  const bool is_held = row.lease_until > DatabaseNow(database);
  uint32_t elsewhere = kNobody;
  if (is_held && row.holder != facts.e) {
    elsewhere = StoreOf(row.holder);
  } else if (!is_held || row.holder != facts.e) {
    const map_store::StoreDuty duty = stores_[facts.c].duty;
    if (duty != map_store::StoreDuty::kTakesMissions || row.wanted != kNobody) {
      CountStatements(database, 1);
      const std::vector<DirectoryStore> stores = ListStores(database, facts.c);
      const DirectoryStore* taker =
          map_store::FindTaker(duty, row.wanted == kNobody ? "" : NameOf(row.wanted), stores);
      if (taker != nullptr) elsewhere = StoreNamed(taker->name);
    }
  }
  if (elsewhere != kNobody) {
    return After(Way(), &FleetEngine::NoteElsewhere,
                 {.b = elsewhere, .c = facts.c, .d = facts.d, .e = facts.e});
  }
  After(2 * Way(), &FleetEngine::Take, facts);
}

void FleetEngine::Take(const Facts& facts) {
  Facts answer{.b = kNobody, .c = facts.c, .d = facts.d, .e = facts.e};
  if (!IsReached(facts.c) || stores_[facts.c].process != facts.e) {
    return After(kDatabaseTimeout, &FleetEngine::NoteElsewhere, answer);
  }
  const uint32_t database = DatabaseOf(facts.c);
  CountStatements(database, 2);
  SimulatedMission& row = missions_[facts.d];
  const Nanos clock = DatabaseNow(database);
  if (!map_store::MayTake({row.holder, row.epoch, Left(row.lease_until, clock)}, facts.e)) {
    answer.b = StoreOf(row.holder);
    return After(Way(), &FleetEngine::NoteElsewhere, answer);
  }
  ++row.epoch;
  row.holder = row.taken_by = facts.e;
  row.wanted = kNobody;
  row.lease_until = clock + absl::ToInt64Nanoseconds(options_.lease);
  stores_[facts.c].row_missions.push_back(facts.d);
  ++result_.takes;
  answer.f = row.epoch;
  After(Way(), &FleetEngine::NoteTaken, answer);
}

void FleetEngine::NoteTaken(const Facts& facts) {
  if (!IsForStore(&FleetEngine::NoteTaken, facts)) return;
  // An answer that is lost is no answer: the row says that the store has it, which finds that out
  // when it is asked again.
  if (!IsReached(facts.c)) {
    return After(kDatabaseTimeout, &FleetEngine::NoteElsewhere, facts);
  }
  SimulatedStore& store = stores_[facts.c];
  store.loader_free_at =
      std::max(store.loader_free_at, now()) + absl::ToInt64Nanoseconds(options_.loading);
  timeline_.At(store.loader_free_at, &FleetEngine::NoteLoaded, facts);
}

void FleetEngine::NoteLoaded(const Facts& facts) {
  if (!IsForStore(&FleetEngine::NoteLoaded, facts)) return;
  SimulatedStore& store = stores_[facts.c];
  const auto it = store.loaded.find(facts.d);
  if (it == store.loaded.end()) return;
  if (!IsReached(facts.c) || Refuses(store)) {
    return NoteElsewhere({.b = kNobody, .c = facts.c, .d = facts.d, .e = facts.e});
  }
  // It reads what is there now. If somebody has taken the mission meanwhile, it may read what that
  // one has written, and is refused from its first write on.
  LoadedMission& loaded = it->second;
  loaded.stage = LoadedMission::Stage::kReady;
  loaded.epoch = facts.f;
  loaded.known.clear();
  for (uint32_t i = 0; i < robots_each_; ++i) {
    loaded.known.push_back(robots_[facts.d * robots_each_ + i].stored);
  }
  for (const uint32_t robot : std::exchange(loaded.waiting, {})) {
    if (robots_[robot].store == facts.c) OpenSession(robot, facts.c, loaded);
  }
}

void FleetEngine::NoteElsewhere(const Facts& facts) {
  if (!IsForStore(&FleetEngine::NoteElsewhere, facts)) return;
  LoadedMission gone;
  SimulatedStore& store = stores_[facts.c];
  const auto it = store.loaded.find(facts.d);
  if (it == store.loaded.end()) return;
  gone = std::move(it->second);
  store.loaded.erase(it);
  for (const uint32_t robot : gone.waiting) {
    if (robots_[robot].store == facts.c) Redirect(robot, facts.b);
  }
}

void FleetEngine::LoseMission(uint32_t at, uint32_t mission, uint32_t to) {
  SimulatedStore& store = stores_[at];
  const auto it = store.loaded.find(mission);
  if (it == store.loaded.end()) return;
  store.loaded.erase(it);
  ++result_.lost;
  for (uint32_t i = 0; i < robots_each_; ++i) {
    const uint32_t robot = mission * robots_each_ + i;
    if (robots_[robot].store == at) Redirect(robot, to);
  }
}

void FleetEngine::GiveAway(uint32_t at, uint32_t mission, uint32_t to, bool balances) {
  const auto it = stores_[at].loaded.find(mission);
  if (it == stores_[at].loaded.end() || it->second.stage != LoadedMission::Stage::kReady) return;
  it->second.stage = LoadedMission::Stage::kClosing;
  After(Between(absl::ZeroDuration(), kBetweenLooks) + Way(), &FleetEngine::Release,
        {.a = balances ? 1u : 0u,
         .b = to,
         .c = at,
         .d = mission,
         .e = stores_[at].process,
         .f = it->second.epoch});
}

void FleetEngine::Release(const Facts& facts) {
  Facts answer = facts;
  SimulatedMission& row = missions_[facts.d];
  const uint32_t database = DatabaseOf(facts.c);
  if (!IsReached(facts.c)) {
    answer.b = kNobody;
    return After(kDatabaseTimeout, &FleetEngine::NoteReleased, answer);
  }
  CountStatements(database, 1);
  if (row.holder == facts.e && row.epoch == facts.f) {
    if (facts.a == 1) {
      ++result_.balancing_moves;
      const Nanos stays = absl::ToInt64Nanoseconds(options_.balance.mission_stays);
      if (now() - row.balanced_at < stays) {
        Violate(absl::StrCat("mission ", facts.d, " moves twice to balance loads within ",
                             (now() - row.balanced_at) / 1'000'000'000, " s"));
      }
      row.balanced_at = now();
    } else {
      ++result_.drained_moves;
    }
    row.holder = 0;
    row.lease_until = kNever;
    row.wanted = facts.b;
    row.moved_at = DatabaseNow(database);
  }
  After(Way(), &FleetEngine::NoteReleased, answer);
}

void FleetEngine::NoteReleased(const Facts& facts) {
  if (!IsForStore(&FleetEngine::NoteReleased, facts)) return;
  SimulatedStore& store = stores_[facts.c];
  const auto it = store.loaded.find(facts.d);
  if (it == store.loaded.end() || it->second.epoch != facts.f) return;
  const std::vector<uint32_t> waiting = std::move(it->second.waiting);
  store.loaded.erase(it);
  for (uint32_t i = 0; i < robots_each_; ++i) {
    const uint32_t robot = facts.d * robots_each_ + i;
    if (robots_[robot].store == facts.c) Redirect(robot, facts.b);
  }
}

}  // namespace corbslam::tests
