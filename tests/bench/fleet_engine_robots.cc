// Implements the part of FleetEngine that is about robots, their sessions and batches.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "tests/bench/fleet_engine.h"

namespace corbslam::tests {
namespace {

// As a robot's link, its channel and its route have them (client_agent/link/store_link.h,
// services/client/remote/channel.h, services/client/remote/store_route.h).
constexpr absl::Duration kMinBackoff = absl::Milliseconds(200);
constexpr absl::Duration kMaxBackoff = absl::Seconds(10);
constexpr Nanos kConnectTimeout = 8'000'000'000;
constexpr int kMaxHops = 4;
// A port that nobody listens on says so at once.
constexpr Nanos kRefused = 5'000'000;

}  // namespace

void FleetEngine::Fail(uint32_t robot) {
  SimulatedRobot& one = robots_[robot];
  ++one.turn;
  one.store = kNobody;
  one.hops = 0;
  if (one.backoff == nullptr) {
    one.backoff = std::make_unique<client_agent::Backoff>(kMinBackoff, kMaxBackoff,
                                                          options_.seed * 1'000'003 + robot);
  }
  After(absl::ToInt64Nanoseconds(one.backoff->Next()), &FleetEngine::Attempt,
        {.a = robot, .b = one.turn, .c = kNobody});
}

void FleetEngine::Redirect(uint32_t robot, uint32_t store) {
  SimulatedRobot& one = robots_[robot];
  ++result_.redirects;
  if (store == kNobody || ++one.hops > kMaxHops) return Fail(robot);
  ++one.turn;
  one.store = kNobody;
  After(RobotsWay(), &FleetEngine::Attempt, {.a = robot, .b = one.turn, .c = store});
}

void FleetEngine::Attempt(const Facts& facts) {
  SimulatedRobot& one = robots_[facts.a];
  if (one.turn != facts.b) return;
  const uint32_t database = DatabaseOfMission(MissionOf(facts.a));
  ++result_.attempts;
  SimulatedDatabase& counting = Counting(database);
  result_.most_attempts = std::max(result_.most_attempts, ++counting.attempts);
  uint32_t to = facts.c;
  // The fleet's name has the addresses of all its stores.
  if (to == kNobody) to = database * stores_each_ + one.next_named++ % stores_each_;
  const SimulatedStore& store = stores_[to];
  Facts opens{.a = facts.a, .b = facts.b, .c = to, .e = store.process};
  if (store.process == 0) return After(kRefused, &FleetEngine::LoseLine, opens);
  if (!store.reached_by_robots) return After(kConnectTimeout, &FleetEngine::LoseLine, opens);
  // A process that is stopped answers nothing; what is on its way may be there when it goes on.
  if (store.paused_until > now() + kConnectTimeout) {
    return After(kConnectTimeout, &FleetEngine::LoseLine, opens);
  }
  After(RobotsWay(), &FleetEngine::ArriveAtStore, opens);
}

void FleetEngine::LoseLine(const Facts& facts) {
  if (robots_[facts.a].turn == facts.b) Fail(facts.a);
}

void FleetEngine::ArriveAtStore(const Facts& facts) {
  SimulatedRobot& robot = robots_[facts.a];
  if (robot.turn != facts.b) return;
  SimulatedStore& store = stores_[facts.c];
  if (store.process != facts.e) return LoseLine(facts);
  if (!IsForStore(&FleetEngine::ArriveAtStore, facts)) return;
  const uint32_t mission = MissionOf(facts.a);
  if (Refuses(store)) return After(RobotsWay(), &FleetEngine::LoseLine, facts);
  const auto [it, is_new] = store.loaded.try_emplace(mission);
  LoadedMission& loaded = it->second;
  if (!is_new && loaded.stage == LoadedMission::Stage::kReady) {
    return OpenSession(facts.a, facts.c, loaded);
  }
  store.sessions.push_back(facts.a);
  loaded.waiting.push_back(facts.a);
  robot.store = facts.c;
  if (is_new) After(Way(), &FleetEngine::Look, {.c = facts.c, .d = mission, .e = store.process});
}

void FleetEngine::OpenSession(uint32_t robot, uint32_t store, const LoadedMission& loaded) {
  SimulatedRobot& one = robots_[robot];
  // The robot is told up to which batch the store has it; what was acknowledged is to be among it.
  if (!stores_[store].reached_by_robots) {
    return After(kSilence, &FleetEngine::LoseLine, {.a = robot, .b = one.turn});
  }
  const uint32_t known = loaded.known[robot % robots_each_];
  if (known < one.acknowledged) {
    Violate(absl::StrCat("robot ", robot, " is told by ", NameOf(store), " of ", known,
                         " batches and had ", one.acknowledged, " acknowledged"));
  }
  ++one.turn;
  one.store = store;
  one.hops = 0;
  one.backoff.reset();
  stores_[store].sessions.push_back(robot);
  After(RobotsWay(), &FleetEngine::SendBatch, {.a = robot, .b = one.turn});
}

void FleetEngine::SendBatch(const Facts& facts) {
  const SimulatedRobot& robot = robots_[facts.a];
  if (robot.turn != facts.b) return;
  const SimulatedStore& store = stores_[robot.store];
  if (!store.reached_by_robots) return After(kSilence, &FleetEngine::LoseLine, facts);
  After(RobotsWay(), &FleetEngine::TakeBatch,
        {.a = facts.a,
         .b = facts.b,
         .c = robot.store,
         .d = robot.acknowledged + 1,
         .e = store.process});
}

void FleetEngine::TakeBatch(const Facts& facts) {
  if (robots_[facts.a].turn != facts.b || !IsForStore(&FleetEngine::TakeBatch, facts)) return;
  SimulatedStore& store = stores_[facts.c];
  const auto it = store.loaded.find(MissionOf(facts.a));
  const bool has_it = it != store.loaded.end() && it->second.stage == LoadedMission::Stage::kReady;
  if (Refuses(store) || it == store.loaded.end()) {
    return After(RobotsWay(), &FleetEngine::LoseLine, facts);
  }
  if (!has_it) return;  // It moves; its robots are told in a moment.
  Facts append = facts;
  append.f = it->second.epoch;
  // What is decided is done a moment later, whatever happens to the process meanwhile.
  After(Between(absl::ZeroDuration(), absl::Milliseconds(20)), &FleetEngine::SendAppend, append);
}

void FleetEngine::SendAppend(const Facts& facts) {
  if (!IsForStore(&FleetEngine::SendAppend, facts)) return;
  After(IsReached(facts.c) ? Way() : kDatabaseTimeout,
        IsReached(facts.c) ? &FleetEngine::Append : &FleetEngine::FailAppend, facts);
}

void FleetEngine::Append(const Facts& facts) {
  if (!IsReached(facts.c)) return After(kDatabaseTimeout, &FleetEngine::FailAppend, facts);
  const uint32_t mission = MissionOf(facts.a);
  const uint32_t database = DatabaseOfMission(mission);
  SimulatedDatabase& counting = Counting(database);
  result_.most_appends = std::max(result_.most_appends, ++counting.appends);
  SimulatedMission& row = missions_[mission];
  const map_store::MissionHolding holding{row.holder, row.epoch, absl::ZeroDuration()};
  if (options_.checks_epoch && !map_store::MayWrite(holding, facts.f)) {
    ++result_.refused_writes;
    return After(Way(), &FleetEngine::FailAppend, facts);
  }
  if (row.taken_by != facts.e) {
    Violate(absl::StrCat("process ", facts.e, " writes into mission ", mission, ", which process ",
                         row.taken_by, " took in epoch ", row.epoch));
  }
  SimulatedRobot& robot = robots_[facts.a];
  if (facts.d > robot.stored + 1) {
    Violate(
        absl::StrCat("batch ", facts.d, " of robot ", facts.a, " follows batch ", robot.stored));
  }
  robot.stored = std::max(robot.stored, facts.d);
  row.lease_until = DatabaseNow(database) + absl::ToInt64Nanoseconds(options_.lease);
  // The answer may get lost.
  if (options_.between_faults < absl::InfiniteDuration() && Chance(1e-4)) {
    return After(kDatabaseTimeout, &FleetEngine::FailAppend, facts);
  }
  After(Way(), &FleetEngine::NoteAppended, facts);
}

void FleetEngine::NoteAppended(const Facts& facts) {
  if (!IsForStore(&FleetEngine::NoteAppended, facts)) return;
  if (!IsReached(facts.c)) return After(kDatabaseTimeout, &FleetEngine::FailAppend, facts);
  SimulatedStore& store = stores_[facts.c];
  const auto it = store.loaded.find(MissionOf(facts.a));
  if (it != store.loaded.end() && it->second.epoch == facts.f) {
    uint32_t& known = it->second.known[facts.a % robots_each_];
    known = std::max(known, facts.d);
  }
  if (!store.reached_by_robots) return After(kSilence, &FleetEngine::LoseLine, facts);
  After(RobotsWay(), &FleetEngine::Acknowledge, facts);
}

void FleetEngine::FailAppend(const Facts& facts) {
  if (!IsForStore(&FleetEngine::FailAppend, facts)) return;
  const uint32_t mission = MissionOf(facts.a);
  const SimulatedMission& row = missions_[mission];
  const auto it = stores_[facts.c].loaded.find(mission);
  // Refused: the database says who has it.
  if (IsReached(facts.c) && row.epoch != facts.f && it != stores_[facts.c].loaded.end() &&
      it->second.epoch == facts.f) {
    return LoseMission(facts.c, mission, StoreOf(row.holder));
  }
  LoseLine(facts);
}

void FleetEngine::Acknowledge(const Facts& facts) {
  SimulatedRobot& robot = robots_[facts.a];
  if (robot.turn != facts.b) return;
  if (facts.d > robot.stored) {
    Violate(absl::StrCat("batch ", facts.d, " of robot ", facts.a,
                         " is acknowledged and not in the database"));
  }
  robot.acknowledged = std::max(robot.acknowledged, facts.d);
  ++result_.acknowledged;
  NoteServed(MissionOf(facts.a));
  const Nanos pace = absl::ToInt64Nanoseconds(options_.between_batches);
  After(pace / 2 + Between(absl::ZeroDuration(), options_.between_batches), &FleetEngine::SendBatch,
        {.a = facts.a, .b = facts.b});
}

}  // namespace corbslam::tests
