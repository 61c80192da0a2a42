#include "tests/bench/fleet_simulation.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/bench/fleet_engine.h"

namespace corbslam::tests {
namespace {

constexpr size_t kMostViolations = 20;
// Of the bound within which a mission is served again: an address that does not answer, and the
// longest wait between attempts.
constexpr absl::Duration kAttempt = absl::Seconds(8 + 10);

double Quantile(std::vector<float>& sorted, double q) {
  if (sorted.empty()) return 0;
  return sorted[std::min(sorted.size() - 1,
                         static_cast<size_t>(q * static_cast<double>(sorted.size())))];
}

}  // namespace

FleetEngine::FleetEngine(const FleetOptions& options)
    : options_(options),
      stores_each_(static_cast<uint32_t>(options.stores_per_database)),
      missions_each_(static_cast<uint32_t>(options.missions_per_database)),
      robots_each_(static_cast<uint32_t>(options.robots_per_mission)),
      random_(options.seed),
      databases_(static_cast<size_t>(options.databases)),
      stores_(databases_.size() * stores_each_),
      missions_(databases_.size() * missions_each_),
      robots_(missions_.size() * robots_each_),
      processes_({kNobody}),
      hit_at_(missions_.size(), kNever) {
  // On average a store is half busy.
  std::uniform_real_distribution<float> weights(0.2F, 1.8F);
  const float mean = 2.0F * static_cast<float>(stores_each_) / static_cast<float>(missions_each_);
  for (SimulatedMission& mission : missions_) mission.weight = mean * weights(random_);
  for (uint32_t at = 0; at < stores_.size(); ++at) Restart({.c = at});
  // Robots come within the first ten seconds.
  for (uint32_t robot = 0; robot < robots_.size(); ++robot) {
    robots_[robot].next_named = std::uniform_int_distribution<uint32_t>(0, stores_each_)(random_);
    timeline_.At(Between(absl::Seconds(1), absl::Seconds(11)), &FleetEngine::Attempt,
                 {.a = robot, .b = 0, .c = kNobody});
  }
}

FleetResult FleetEngine::Run() {
  const Nanos disaster_at = absl::ToUnixNanos(options_.disaster_at);
  const Nanos end = absl::ToInt64Nanoseconds(options_.duration);
  if (options_.between_faults < absl::InfiniteDuration()) {
    for (uint32_t i = 0; i < databases_.size(); ++i) {
      timeline_.At(Between(absl::Seconds(15), absl::Seconds(30)), &FleetEngine::HappenAtRandom,
                   {.c = i});
    }
  }
  if (options_.disaster != Disaster::kNone) {
    timeline_.At(disaster_at, &FleetEngine::StrikeDisaster, {});
    // All have come and are served: what is counted from here on is the calm.
    timeline_.Run(*this, disaster_at / 2);
    const uint64_t statements = calm_statements_;
    const uint64_t appends = result_.acknowledged;
    result_.most_directory_statements = result_.most_appends = result_.most_attempts = 0;
    timeline_.Run(*this, disaster_at - 1);
    const double seconds = static_cast<double>(disaster_at - disaster_at / 2) * 1e-9 *
                           static_cast<double>(databases_.size());
    result_.directory_statements = static_cast<double>(calm_statements_ - statements) / seconds;
    result_.appends = static_cast<double>(result_.acknowledged - appends) / seconds;
  }
  timeline_.Run(*this, end);
  ends_ = true;
  timeline_.Run(*this, end + absl::ToInt64Nanoseconds(options_.calm));
  Finish();
  return std::move(result_);
}

void FleetEngine::Finish() {
  for (uint32_t mission = 0; mission < missions_.size(); ++mission) CheckServed(mission);
  for (uint32_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i].acknowledged > robots_[i].stored) {
      Violate(absl::StrCat("robot ", i, " has lost what was acknowledged"));
    }
  }
  std::sort(interruptions_s_.begin(), interruptions_s_.end());
  result_.events = timeline_.events();
  result_.interruptions = interruptions_s_.size();
  result_.interruption_p50_s = Quantile(interruptions_s_, 0.5);
  result_.interruption_p99_s = Quantile(interruptions_s_, 0.99);
  result_.interruption_max_s = interruptions_s_.empty() ? 0 : interruptions_s_.back();
  std::sort(served_after_s_.begin(), served_after_s_.end());
  result_.most_served_after_s = Quantile(served_after_s_, 0.99);
  result_.all_served_after_s = served_after_s_.empty() ? 0 : served_after_s_.back();
}

absl::Time FleetEngine::OwnNow(const SimulatedStore& store) const {
  return absl::FromUnixNanos(static_cast<Nanos>(static_cast<double>(now()) * store.clock_rate));
}

Nanos FleetEngine::Between(absl::Duration least, absl::Duration most) {
  return std::uniform_int_distribution<Nanos>(absl::ToInt64Nanoseconds(least),
                                              absl::ToInt64Nanoseconds(most))(random_);
}

bool FleetEngine::IsForStore(Happens happens, const Facts& facts) {
  const SimulatedStore& store = stores_[facts.c];
  if (store.process != facts.e) return false;
  if (store.paused_until <= now()) return true;
  timeline_.At(store.paused_until, happens, facts);
  return false;
}

bool FleetEngine::IsReached(uint32_t store) const {
  return stores_[store].reaches_database && databases_[DatabaseOf(store)].is_up;
}

bool FleetEngine::Refuses(const SimulatedStore& store) const {
  return options_.checks_own_lease && store.own_lease->IsOver(OwnNow(store));
}

SimulatedDatabase& FleetEngine::Counting(uint32_t at) {
  SimulatedDatabase& database = databases_[at];
  const int64_t second = now() / 1'000'000'000;
  if (second != database.second) {
    database.second = second;
    database.statements = database.appends = database.attempts = 0;
  }
  return database;
}

void FleetEngine::CountStatements(uint32_t at, uint64_t statements) {
  SimulatedDatabase& database = Counting(at);
  database.statements += statements;
  calm_statements_ += statements;
  result_.most_directory_statements =
      std::max(result_.most_directory_statements, database.statements);
}

bool FleetEngine::IsHealthy(uint32_t database) const {
  if (!databases_[database].is_up) return false;
  for (uint32_t at = database * stores_each_; at < (database + 1) * stores_each_; ++at) {
    const SimulatedStore& store = stores_[at];
    if (store.process != 0 && store.paused_until <= now() && store.reaches_database &&
        store.reached_by_robots) {
      return true;
    }
  }
  return false;
}

Nanos FleetEngine::Bound(uint32_t database) const {
  int64_t silent = 0;
  int64_t healthy = 0;
  for (uint32_t at = database * stores_each_; at < (database + 1) * stores_each_; ++at) {
    const SimulatedStore& store = stores_[at];
    const bool answers =
        store.process == 0 || (store.paused_until <= now() && store.reached_by_robots);
    silent += !answers || !store.reaches_database;
    healthy += store.process != 0 && answers && store.reaches_database;
  }
  // Whoever is left reads all missions; half of them twice, where they were given on.
  const absl::Duration reading =
      options_.loading * missions_each_ * 3 / 2 / std::max<int64_t>(healthy, 1);
  return kSilence + kDatabaseTimeout +
         absl::ToInt64Nanoseconds(options_.lease + reading + (silent + 2) * kAttempt +
                                  2 * options_.between_batches);
}

void FleetEngine::CheckServed(uint32_t mission) {
  const uint32_t database = DatabaseOfMission(mission);
  const Nanos since = std::max(missions_[mission].served_at, databases_[database].changed_at);
  if (now() - since <= Bound(database) || !IsHealthy(database)) return;
  Violate(absl::StrFormat("mission %d was not served for %.1f s, with nothing wrong since: %.1f s",
                          mission, static_cast<double>(now() - missions_[mission].served_at) * 1e-9,
                          static_cast<double>(now() - since) * 1e-9));
}

void FleetEngine::NoteServed(uint32_t mission) {
  SimulatedMission& one = missions_[mission];
  CheckServed(mission);
  const double gap_s = static_cast<double>(now() - one.served_at) * 1e-9;
  const bool came_before = one.served_at > 0;
  one.served_at = now();
  const double usual_s = 2 * absl::ToDoubleSeconds(options_.between_batches) + 1;
  if (came_before && gap_s > usual_s) interruptions_s_.push_back(static_cast<float>(gap_s));
  if (hit_at_[mission] == kNever) return;
  served_after_s_.push_back(
      static_cast<float>(static_cast<double>(now() - hit_at_[mission]) * 1e-9));
  hit_at_[mission] = kNever;
}

void FleetEngine::Violate(const std::string& what) {
  if (result_.violations.size() >= kMostViolations) return;
  result_.violations.push_back(absl::StrFormat("seed %d, %.3f s: %s", options_.seed,
                                               static_cast<double>(now()) * 1e-9, what));
}

FleetResult SimulateFleet(const FleetOptions& options) { return FleetEngine(options).Run(); }

}  // namespace corbslam::tests
