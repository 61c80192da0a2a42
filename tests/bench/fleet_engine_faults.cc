// Implements the part of FleetEngine that does harm: processes that are killed or stopped, ways
// that are cut, databases that are away or change, stores that an operator drains.
#include <algorithm>

#include "tests/bench/fleet_engine.h"

namespace corbslam::tests {

using map_store::StoreDuty;

namespace {

constexpr Nanos kReset = 20'000'000;

}  // namespace

void FleetEngine::HappenAtRandom(const Facts& facts) {
  if (ends_) return;
  const uint32_t database = facts.c;
  const double mean_s = absl::ToDoubleSeconds(options_.between_faults);
  std::exponential_distribution<double> waits(1 / mean_s);
  After(static_cast<Nanos>(waits(random_) * 1e9), &FleetEngine::HappenAtRandom, facts);
  std::uniform_int_distribution<uint32_t> any(0, stores_each_ - 1);
  const uint32_t store = database * stores_each_ + any(random_);
  ++result_.faults;
  switch (std::uniform_int_distribution<int>(0, 9)(random_)) {
    case 0:
    case 1:
      return Kill(store);
    case 2:
    case 3:
    case 4:
      return Pause(store, Between(absl::Milliseconds(100), absl::Seconds(60)));
    case 5:
    case 6:
      return CutFromDatabase(store, Between(absl::Seconds(1), absl::Seconds(60)));
    case 7:
      return CutFromRobots(store, Between(absl::Seconds(1), absl::Seconds(60)));
    case 8:
      return StopDatabase(database, Between(absl::Seconds(1), absl::Seconds(30)));
    default:
      SetDuty(store, Chance(0.5) ? StoreDuty::kDrained : StoreDuty::kCordoned);
      return After(Between(absl::Seconds(10), absl::Seconds(60)), &FleetEngine::Uncordon,
                   {.c = store});
  }
}

void FleetEngine::Kill(uint32_t at) {
  SimulatedStore& store = stores_[at];
  if (store.process == 0) return;
  NoteChange(DatabaseOf(at));
  store.process = 0;
  store.loaded.clear();
  store.paused_until = kNever;
  BreakSessions(at, kReset);
  After(Between(absl::Seconds(1), absl::Seconds(60)), &FleetEngine::Restart, {.c = at});
}

void FleetEngine::Restart(const Facts& facts) {
  SimulatedStore& store = stores_[facts.c];
  if (store.process != 0) return;
  NoteChange(DatabaseOf(facts.c));
  processes_.push_back(facts.c);
  store.process = static_cast<int64_t>(processes_.size() - 1);
  store.duty = StoreDuty::kTakesMissions;
  store.loader_free_at = now();
  store.meter = map_store::LoadMeter();
  store.weighed.reset();
  store.clock_rate = 1 + std::uniform_real_distribution<double>(-options_.clock_error,
                                                                options_.clock_error)(random_);
  store.own_lease = std::make_unique<map_store::OwnLease>(options_.lease, OwnNow(store));
  After(Way(), &FleetEngine::Announce, {.c = facts.c, .e = store.process});
}

void FleetEngine::Pause(uint32_t at, Nanos length) {
  SimulatedStore& store = stores_[at];
  if (store.process == 0 || store.paused_until > now()) return;
  NoteChange(DatabaseOf(at));
  store.paused_until = now() + length;
  timeline_.At(store.paused_until, &FleetEngine::Resume, {.c = at, .e = store.process});
  if (length > kSilence) After(kSilence, &FleetEngine::NotePause, {.c = at, .e = store.process});
}

void FleetEngine::NotePause(const Facts& facts) {
  const SimulatedStore& store = stores_[facts.c];
  if (store.process == facts.e && store.paused_until > now()) BreakSessions(facts.c, 0);
}

void FleetEngine::Resume(const Facts& facts) {
  if (stores_[facts.c].process == facts.e) NoteChange(DatabaseOf(facts.c));
}

void FleetEngine::CutFromDatabase(uint32_t at, Nanos length) {
  SimulatedStore& store = stores_[at];
  if (!store.reaches_database) return;
  NoteChange(DatabaseOf(at));
  store.reaches_database = false;
  After(length, &FleetEngine::MendToDatabase, {.c = at});
}

void FleetEngine::MendToDatabase(const Facts& facts) {
  NoteChange(DatabaseOf(facts.c));
  stores_[facts.c].reaches_database = true;
}

void FleetEngine::CutFromRobots(uint32_t at, Nanos length) {
  SimulatedStore& store = stores_[at];
  if (!store.reached_by_robots) return;
  NoteChange(DatabaseOf(at));
  store.reached_by_robots = false;
  BreakSessions(at, kSilence);
  After(length, &FleetEngine::MendToRobots, {.c = at});
}

void FleetEngine::MendToRobots(const Facts& facts) {
  NoteChange(DatabaseOf(facts.c));
  stores_[facts.c].reached_by_robots = true;
}

void FleetEngine::StopDatabase(uint32_t database, Nanos length) {
  if (!databases_[database].is_up) return;
  NoteChange(database);
  databases_[database].is_up = false;
  After(length, &FleetEngine::StartDatabase, {.c = database});
}

void FleetEngine::StartDatabase(const Facts& facts) {
  SimulatedDatabase& database = databases_[facts.c];
  NoteChange(facts.c);
  database.is_up = true;
  // A standby that becomes the primary has a clock of its own, and all that was committed.
  database.clock_ahead = Between(absl::ZeroDuration(), absl::Seconds(2)) - 1'000'000'000;
}

void FleetEngine::SetDuty(uint32_t store, StoreDuty duty) {
  NoteChange(DatabaseOf(store));
  stores_[store].row_duty = duty;
}

void FleetEngine::Uncordon(const Facts& facts) { SetDuty(facts.c, StoreDuty::kTakesMissions); }

void FleetEngine::BreakSessions(uint32_t at, Nanos later) {
  std::vector<uint32_t> sessions = std::move(stores_[at].sessions);
  stores_[at].sessions.clear();
  std::sort(sessions.begin(), sessions.end());
  sessions.erase(std::unique(sessions.begin(), sessions.end()), sessions.end());
  for (const uint32_t robot : sessions) {
    if (robots_[robot].store != at) continue;
    After(later + RobotsWay(), &FleetEngine::LoseLine, {.a = robot, .b = robots_[robot].turn});
  }
}

void FleetEngine::StrikeDisaster(const Facts&) {
  const auto hit_all = [this](uint32_t database) {
    for (uint32_t i = 0; i < missions_each_; ++i) hit_at_[database * missions_each_ + i] = now();
  };
  switch (options_.disaster) {
    case Disaster::kNone:
      return;
    case Disaster::kLostRack:
      // A tenth of all stores, wherever they are, at once and for good.
      for (uint32_t at = 0; at < stores_.size(); at += 10) {
        for (const uint32_t mission : stores_[at].row_missions) {
          if (missions_[mission].holder == stores_[at].process) hit_at_[mission] = now();
        }
        Kill(at);
        stores_[at].reached_by_robots = false;  // Nobody answers for its address any more.
        stores_[at].reaches_database = false;
      }
      return;
    case Disaster::kLostDatabase:
      hit_all(0);
      return StopDatabase(0, 60'000'000'000);
    case Disaster::kHerd:
      // Robots lose all stores for a minute, and come back at once.
      for (uint32_t database = 0; database < databases_.size(); ++database) hit_all(database);
      for (uint32_t at = 0; at < stores_.size(); ++at) CutFromRobots(at, 60'000'000'000);
      return;
  }
}

}  // namespace corbslam::tests
