// What many robots get from one store over time: synthetic robots on shared ground
// (synthetic_fleet.h), each with a thread of its own, give keyframes at a pace in real time to a
// store with a journal, whose fusion runs in its own threads with a worker that believes. Prints,
// minute by minute, how soon batches were durable, what waits to be looked up and how much memory
// is in use; writes JSON.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "services/programs/default_vocabulary.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/synthetic_fleet.h"
#include "tests/replay/quantile.h"

namespace corbslam::tests {

using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::MissionInfo;
using map_store::RocksJournal;
using map_store::RocksJournalOptions;
using services::DefaultVocabularyPath;

namespace {

using Json = nlohmann::ordered_json;

constexpr char kMission[] = "many";

struct Flags {
  size_t robots = 20;
  double keyframes_per_s = 5;
  double minutes = 10;
  size_t features = 1000;
  std::string data_dir;
  std::string json;
};

// Thread-safe. What the robots have lived through since it was asked last.
class Ledger {
 public:
  struct Minute {
    std::vector<double> acknowledged_ms;
    std::vector<double> shared_ms;
  };

  void NoteAcknowledged(double ms) {
    absl::MutexLock lock(&mutex_);
    minute_.acknowledged_ms.push_back(ms);
    ++acknowledged_;
  }
  void NoteShared(double ms) {
    absl::MutexLock lock(&mutex_);
    minute_.shared_ms.push_back(ms);
  }
  // The first one stays.
  void NoteFailure(const absl::Status& status) {
    absl::MutexLock lock(&mutex_);
    failure_.Update(status);
  }
  Minute Take() {
    absl::MutexLock lock(&mutex_);
    return std::exchange(minute_, {});
  }
  absl::Status failure() const {
    absl::MutexLock lock(&mutex_);
    return failure_;
  }
  size_t acknowledged() const {
    absl::MutexLock lock(&mutex_);
    return acknowledged_;
  }

 private:
  mutable absl::Mutex mutex_;
  Minute minute_ ABSL_GUARDED_BY(mutex_);
  size_t acknowledged_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
};

class Fleet {
 public:
  Fleet(const Flags& flags, MapStore& store)
      : flags_(flags), store_(store), fleet_(OptionsOf(flags)) {}
  ~Fleet() { Stop(); }

  // Opens a session for each robot, then sets out.
  absl::Status Start() {
    std::vector<uint64_t> sessions;
    for (size_t i = 0; i < flags_.robots; ++i) {
      SessionRequest request;
      request.mission = kMission;
      request.agent = absl::StrCat("robot-", i);
      ASSIGN_OR_RETURN(const MapStore::OpenedSession opened, store_.OpenSession(request));
      sessions.push_back(opened.session_id);
    }
    start_ = absl::Now();
    for (size_t i = 0; i < flags_.robots; ++i) {
      threads_.emplace_back([this, i, session = sessions[i]] { Drive(i, session); });
    }
    return absl::OkStatus();
  }

  void Stop() {
    if (!stop_.HasBeenNotified()) stop_.Notify();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

  // Batches that were due by then.
  size_t CountDue(absl::Time now) const {
    return static_cast<size_t>(absl::ToDoubleSeconds(now - start_) * flags_.keyframes_per_s) + 1;
  }
  Ledger& ledger() { return ledger_; }

 private:
  static FleetOptions OptionsOf(const Flags& flags) {
    FleetOptions options;
    options.robots = flags.robots;
    options.features = flags.features;
    return options;
  }

  // The robots take turns.
  absl::Time DueTime(size_t robot, size_t keyframe) const {
    return start_ + absl::Seconds(static_cast<double>(keyframe * flags_.robots + robot) /
                                  flags_.keyframes_per_s);
  }

  MapUpdateBatch NextBatch(size_t robot) {
    absl::MutexLock lock(&fleet_mutex_);
    return fleet_.NextBatch(robot);
  }

  void Drive(size_t robot, uint64_t session) {
    for (size_t keyframe = 0;; ++keyframe) {
      const absl::Time due = DueTime(robot, keyframe);
      // Made before it is due: that is the robot's own work.
      const MapUpdateBatch batch = NextBatch(robot);
      if (stop_.WaitForNotificationWithTimeout(due - absl::Now())) return;
      const absl::Status done = Exchange(session, batch, due);
      if (done.ok()) continue;
      ledger_.NoteFailure(done);
      return;
    }
  }

  // Gives the batch, and takes all that there is of others.
  absl::Status Exchange(uint64_t session, const MapUpdateBatch& batch, absl::Time due) {
    constexpr size_t kUpdateBytes = 1 << 20;
    RETURN_IF_ERROR(store_.Apply(session, batch).status());
    ledger_.NoteAcknowledged(absl::ToDoubleMilliseconds(absl::Now() - due));
    while (!stop_.HasBeenNotified()) {
      const absl::Time begin = absl::Now();
      ASSIGN_OR_RETURN(const auto update, store_.NextShared(session, kUpdateBytes));
      ledger_.NoteShared(absl::ToDoubleMilliseconds(absl::Now() - begin));
      if (!update.has_value()) break;
    }
    return absl::OkStatus();
  }

  const Flags& flags_;
  MapStore& store_;
  absl::Mutex fleet_mutex_;
  SyntheticFleet fleet_ ABSL_GUARDED_BY(fleet_mutex_);
  absl::Time start_;
  Ledger ledger_;
  absl::Notification stop_;
  std::vector<std::thread> threads_;
};

absl::StatusOr<Json> MakeRow(const MapStore& store, Fleet& fleet, double minute) {
  const size_t due = fleet.CountDue(absl::Now());
  const size_t acknowledged = fleet.ledger().acknowledged();
  const Ledger::Minute lived = fleet.ledger().Take();
  ASSIGN_OR_RETURN(const MissionInfo info, store.GetMission(kMission));
  return Json{{"minute", minute},
              {"keyframes", info.keyframes},
              {"acknowledged", lived.acknowledged_ms.size()},
              {"overdue", due - std::min(due, acknowledged)},
              {"ack_p50_ms", Quantile(lived.acknowledged_ms, 0.5)},
              {"ack_p99_ms", Quantile(lived.acknowledged_ms, 0.99)},
              {"ack_slowest_ms", Quantile(lived.acknowledged_ms, 1)},
              {"shared_p99_ms", Quantile(lived.shared_ms, 0.99)},
              {"waiting_queries", info.waiting_queries},
              {"islands", info.islands},
              {"revision", info.revision},
              {"resident_mb", static_cast<double>(ResidentBytes()) / 1e6}};
}

void Print(const Json& row) {
  std::printf(
      "| %6.2f | %9zu | %4zu | %7zu | %8.1f | %8.1f | %8.1f | %10.1f | %7zu | %7zu | %6.0f |\n",
      row["minute"].get<double>(), row["keyframes"].get<size_t>(),
      row["acknowledged"].get<size_t>(), row["overdue"].get<size_t>(),
      row["ack_p50_ms"].get<double>(), row["ack_p99_ms"].get<double>(),
      row["ack_slowest_ms"].get<double>(), row["shared_p99_ms"].get<double>(),
      row["waiting_queries"].get<size_t>(), row["islands"].get<size_t>(),
      row["resident_mb"].get<double>());
  std::fflush(stdout);
}

absl::StatusOr<Json> Watch(const Flags& flags, const MapStore& store, Fleet& fleet) {
  std::printf(
      "| minute | keyframes | acks | overdue | p50, ms  | p99, ms  | slowest  | shared p99 | "
      "queries | islands | MB     |\n"
      "| ------ | --------- | ---- | ------- | -------- | -------- | -------- | ---------- | "
      "------- | ------- | ------ |\n");
  Json rows = Json::array();
  const absl::Time begin = absl::Now();
  for (double minute = 0; minute < flags.minutes;) {
    minute = std::min(minute + 1, flags.minutes);
    absl::SleepFor(begin + absl::Minutes(minute) - absl::Now());
    RETURN_IF_ERROR(fleet.ledger().failure());
    ASSIGN_OR_RETURN(Json row, MakeRow(store, fleet, minute));
    Print(row);
    rows.push_back(std::move(row));
  }
  return rows;
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const Vocabulary> vocabulary,
                   Vocabulary::Load(DefaultVocabularyPath()));
  std::filesystem::remove_all(flags.data_dir);
  RocksJournalOptions journal_options;
  journal_options.directory = flags.data_dir;
  ASSIGN_OR_RETURN(std::unique_ptr<RocksJournal> journal, RocksJournal::Open(journal_options));
  BelievingWorker worker;
  MapStore store(MapStoreOptions(), vocabulary, std::move(journal), &worker);
  Fleet fleet(flags, store);
  RETURN_IF_ERROR(fleet.Start());
  ASSIGN_OR_RETURN(const Json rows, Watch(flags, store, fleet));
  fleet.Stop();
  const absl::Time end = absl::Now();
  const absl::Status idle = store.WaitUntilFusionIdle(kMission, absl::Minutes(2));
  std::printf("fusion %s after %.1f s\n", idle.ok() ? "idle" : "not idle",
              absl::ToDoubleSeconds(absl::Now() - end));
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({Json{{"robots", flags.robots},
                          {"keyframes_per_s", flags.keyframes_per_s},
                          {"features", flags.features},
                          {"rows", rows}}
                         .dump(2)},
                    flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("Many robots, one store, minute by minute", "many_robots");
  app.add_option("--robots", flags.robots, "On the same ground")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--pace", flags.keyframes_per_s, "Keyframes a second of all together")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--minutes", flags.minutes, "How long")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--features", flags.features, "Of a keyframe")
      ->check(CLI::Range(1, 20000))
      ->capture_default_str();
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal; made new")->required();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  if (const absl::Status status = corbslam::tests::Run(flags); !status.ok()) {
    std::fprintf(stderr, "many_robots: %s\n", status.ToString().c_str());
    return 1;
  }
  return 0;
}
