// What a mission costs as it grows: synthetic robots on shared ground (synthetic_fleet.h) fill one,
// with a journal, and at some sizes it is measured what a batch, a shared update, fusion, pages,
// watching, a backup and a keyframe's memory take. Prints a table and writes JSON.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "map_store/mission/mission_load.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "services/map_store_service/map_changes_to_proto.h"
#include "services/programs/default_vocabulary.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/synthetic_fleet.h"
#include "tests/replay/quantile.h"

namespace corbslam::tests {

using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::MapWatcher;
using map_store::MissionBackup;
using map_store::MissionLoad;
using map_store::MissionStatistics;
using map_store::PageRequest;
using map_store::RocksJournal;
using map_store::RocksJournalOptions;
using services::DefaultVocabularyPath;
using services::ToProto;

namespace {

using Json = nlohmann::ordered_json;

constexpr char kMission[] = "long";

struct Flags {
  std::vector<size_t> keyframes = {500, 1000, 2000, 5000, 10000};
  size_t robots = 10;
  size_t features = 1000;
  std::string data_dir;
  std::string json;
};

double Milliseconds(absl::Time since) { return absl::ToDoubleMilliseconds(absl::Now() - since); }

// Times that a look-up which needs the state's lock for a moment takes, all the while: as long as
// somebody holds it for writing, it waits.
class LockProbe {
 public:
  LockProbe(const MapStore& store, LocalMapId local_map)
      : thread_([this, &store, local_map] {
          while (!stop_) {
            const absl::Time begin = absl::Now();
            (void)store.GetLocalMap(kMission, local_map);
            const double ms = Milliseconds(begin);
            {
              absl::MutexLock lock(&mutex_);
              ms_.push_back(ms);
            }
            absl::SleepFor(absl::Microseconds(300));
          }
        }) {}
  ~LockProbe() {
    stop_ = true;
    thread_.join();
  }
  std::vector<double> Take() {
    absl::MutexLock lock(&mutex_);
    return std::exchange(ms_, {});
  }

 private:
  std::atomic<bool> stop_ = false;
  absl::Mutex mutex_;
  std::vector<double> ms_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

// Counts what workers are asked to verify: that does not depend on what else the machine does.
class CountingWorker : public BelievingWorker {
 public:
  struct Counts {
    size_t requests = 0;
    size_t keyframes = 0;  // Of the requests' views.
  };

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    ++counts_.requests;
    counts_.keyframes +=
        request.query_view->keyframes().size() + request.candidate_view.keyframes().size();
    return BelievingWorker::VerifyOverlap(request, progress);
  }
  Counts Take() { return std::exchange(counts_, {}); }

 private:
  // A deterministic store asks from the thread that runs its fusion.
  Counts counts_;
};

// What was measured since the last row.
struct Spell {
  std::vector<double> apply_ms;
  std::vector<double> locked_ms;  // Of these, under the state's lock for writing.
  std::vector<double> shared_ms;
  std::vector<double> fusion_ms;
};

class LongMission {
 public:
  LongMission(const Flags& flags, MapStore& store, CountingWorker& worker)
      : store_(store), worker_(worker), fleet_(Options(flags)) {}

  // Begins the next row: it is about what comes from here on.
  void Begin(LockProbe& probe) {
    spell_ = {};
    worker_.Take();
    probe.Take();
  }

  absl::Status Open() {
    for (size_t i = 0; i < fleet_.robots(); ++i) {
      SessionRequest request;
      request.mission = kMission;
      request.agent = absl::StrCat("robot-", i);
      ASSIGN_OR_RETURN(const MapStore::OpenedSession opened, store_.OpenSession(request));
      sessions_.push_back(opened.session_id);
    }
    return absl::OkStatus();
  }

  absl::Status AddKeyframe() {
    const size_t robot = keyframes_ % fleet_.robots();
    const MapUpdateBatch batch = fleet_.NextBatch(robot);
    const double written_s = Load().written_s;
    absl::Time begin = absl::Now();
    RETURN_IF_ERROR(store_.Apply(sessions_[robot], batch).status());
    spell_.apply_ms.push_back(Milliseconds(begin));
    spell_.locked_ms.push_back(1e3 * (Load().written_s - written_s));
    begin = absl::Now();
    RETURN_IF_ERROR(store_.RunFusionUntilIdle(kMission));
    spell_.fusion_ms.push_back(Milliseconds(begin));
    begin = absl::Now();
    RETURN_IF_ERROR(store_.NextShared(sessions_[robot], 1 << 20).status());
    spell_.shared_ms.push_back(Milliseconds(begin));
    ++keyframes_;
    return absl::OkStatus();
  }

  absl::StatusOr<Json> Measure(LockProbe& probe) {
    Json row = {{"keyframes", keyframes_}, {"points", fleet_.point_count()}};
    const auto spread = [&row](const char* what, const std::vector<double>& ms) {
      row[absl::StrCat(what, "_p50_ms")] = Quantile(ms, 0.5);
      row[absl::StrCat(what, "_p99_ms")] = Quantile(ms, 0.99);
    };
    spread("batch", spell_.apply_ms);
    spread("batch_locked", spell_.locked_ms);
    row["longest_lock_so_far_ms"] = 1e3 * Load().longest_write_s;
    spread("shared_update", spell_.shared_ms);
    spread("fusion", spell_.fusion_ms);
    AddFusion(row);
    const std::vector<double> probed_ms = probe.Take();
    row["wait_for_lock_p99_ms"] = Quantile(probed_ms, 0.99);
    row["longest_wait_for_lock_ms"] = Quantile(probed_ms, 1);
    ASSIGN_OR_RETURN(const MissionStatistics statistics, store_.GetStatistics(kMission));
    row["revision"] = statistics.revision;
    row["islands"] = statistics.islands;
    row["adjustments"] = statistics.global_adjustments.size();
    RETURN_IF_ERROR(MeasurePages(row));
    RETURN_IF_ERROR(MeasureWatching(row));
    RETURN_IF_ERROR(MeasureBackup(probe, row));
    row["kB_per_keyframe"] =
        static_cast<double>(ResidentBytes() - std::min(ResidentBytes(), resident_at_start_)) / 1e3 /
        static_cast<double>(std::max<size_t>(keyframes_, 1));
    return row;
  }

  LocalMapId first_local_map() const { return fleet_.local_map(0); }
  size_t keyframes() const { return keyframes_; }

 private:
  // The store has no other mission.
  MissionLoad Load() const { return store_.ListLoads().front(); }

  static FleetOptions Options(const Flags& flags) {
    FleetOptions options;
    options.robots = flags.robots;
    options.features = flags.features;
    return options;
  }

  // Adds what fusion took in all, weldings and adjustments with it, for each of the row's
  // keyframes.
  void AddFusion(Json& row) {
    const auto keyframes = static_cast<double>(std::max<size_t>(spell_.fusion_ms.size(), 1));
    row["fusion_mean_ms"] =
        std::accumulate(spell_.fusion_ms.begin(), spell_.fusion_ms.end(), 0.0) / keyframes;
    const CountingWorker::Counts counts = worker_.Take();
    row["verifications_per_keyframe"] = static_cast<double>(counts.requests) / keyframes;
    row["verified_views_keyframes"] = static_cast<double>(counts.keyframes) /
                                      static_cast<double>(std::max<size_t>(counts.requests, 1));
  }

  absl::Status MeasurePages(Json& row) const {
    const PageRequest page = {100, ""};
    absl::Time begin = absl::Now();
    RETURN_IF_ERROR(store_.ListKeyframes(kMission, LocalMapId(), page).status());
    row["page_of_keyframes_ms"] = Milliseconds(begin);
    begin = absl::Now();
    RETURN_IF_ERROR(store_.ListOverlaps(kMission, {}, page).status());
    row["page_of_overlaps_ms"] = Milliseconds(begin);
    begin = absl::Now();
    RETURN_IF_ERROR(store_.GetStatistics(kMission).status());
    row["statistics_ms"] = Milliseconds(begin);
    return absl::OkStatus();
  }

  // Takes all that is new to the watcher, in pieces as the service sends them, and returns the
  // bytes.
  absl::StatusOr<size_t> Watch(MapWatcher& watcher) const {
    constexpr size_t kItemsInAPiece = 5000;
    size_t bytes = 0;
    while (true) {
      ASSIGN_OR_RETURN(const auto changes, store_.NextChanges(kMission, kItemsInAPiece, watcher));
      if (!changes.has_value()) return bytes;
      for (const auto& response : ToProto(*changes)) bytes += response.ByteSizeLong();
    }
  }

  // Measures the whole map, with points, for a new watcher; and what one batch more, with what
  // fusion makes of it, is to a watcher of keyframes who has seen all before (the median of some).
  absl::Status MeasureWatching(Json& row) {
    MapWatcher new_one(0, true);
    absl::Time begin = absl::Now();
    RETURN_IF_ERROR(Watch(new_one).status());
    row["first_watch_ms"] = Milliseconds(begin);
    MapWatcher watcher(0, false);
    RETURN_IF_ERROR(Watch(watcher).status());
    std::vector<double> ms;
    std::vector<double> bytes;
    for (int i = 0; i < 9; ++i) {
      RETURN_IF_ERROR(AddKeyframe());
      begin = absl::Now();
      ASSIGN_OR_RETURN(const size_t some, Watch(watcher));
      ms.push_back(Milliseconds(begin));
      bytes.push_back(static_cast<double>(some));
    }
    row["watch_p50_ms"] = Quantile(ms, 0.5);
    row["watch_p50_bytes"] = Quantile(bytes, 0.5);
    return absl::OkStatus();
  }

  absl::Status MeasureBackup(LockProbe& probe, Json& row) const {
    probe.Take();
    const absl::Time begin = absl::Now();
    ASSIGN_OR_RETURN(MissionBackup backup, store_.BackUpMission(kMission));
    while (!backup.Next(1 << 20).empty()) {
    }
    row["backup_ms"] = Milliseconds(begin);
    row["backup_pause_ms"] = Quantile(probe.Take(), 1);
    return absl::OkStatus();
  }

  MapStore& store_;
  CountingWorker& worker_;
  SyntheticFleet fleet_;
  std::vector<uint64_t> sessions_;
  const uint64_t resident_at_start_ = ResidentBytes();
  size_t keyframes_ = 0;
  Spell spell_;
};

void Print(const Json& row, bool with_header) {
  std::string names = "|";
  std::string lines = "|";
  std::string values = "|";
  for (const auto& [name, value] : row.items()) {
    absl::StrAppend(&names, " ", name, " |");
    lines += " --- |";
    char text[32];
    if (value.is_number_float()) {
      std::snprintf(text, sizeof(text), " %.2f |", value.get<double>());
    } else {
      std::snprintf(text, sizeof(text), " %llu |",
                    static_cast<unsigned long long>(value.get<uint64_t>()));
    }
    values += text;
  }
  if (with_header) std::printf("%s\n%s\n", names.c_str(), lines.c_str());
  std::printf("%s\n", values.c_str());
  std::fflush(stdout);
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const Vocabulary> vocabulary,
                   Vocabulary::Load(DefaultVocabularyPath()));
  std::filesystem::remove_all(flags.data_dir);
  RocksJournalOptions journal_options;
  journal_options.directory = flags.data_dir;
  ASSIGN_OR_RETURN(std::unique_ptr<RocksJournal> journal, RocksJournal::Open(journal_options));
  MapStoreOptions options;
  options.deterministic = true;
  CountingWorker worker;
  MapStore store(options, vocabulary, std::move(journal), &worker);
  LongMission mission(flags, store, worker);
  RETURN_IF_ERROR(mission.Open());
  RETURN_IF_ERROR(mission.AddKeyframe());
  LockProbe probe(store, mission.first_local_map());
  Json rows = Json::array();
  for (const size_t keyframes : flags.keyframes) {
    while (mission.keyframes() < keyframes) RETURN_IF_ERROR(mission.AddKeyframe());
    ASSIGN_OR_RETURN(Json row, mission.Measure(probe));
    mission.Begin(probe);
    Print(row, rows.empty());
    rows.push_back(std::move(row));
    if (flags.json.empty()) continue;
    // Results are written after each row, because a long run may be stopped.
    RETURN_IF_ERROR(
        WriteLines({Json{{"robots", flags.robots}, {"rows", rows}}.dump(2)}, flags.json));
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("What a mission costs as it grows", "long_mission");
  app.add_option("--keyframes", flags.keyframes, "Sizes at which it is measured, rising")
      ->capture_default_str();
  app.add_option("--robots", flags.robots, "On the same ground")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--features", flags.features, "Of a keyframe")
      ->check(CLI::Range(1, 20000))
      ->capture_default_str();
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal; made new")->required();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  FLAGS_minloglevel = google::GLOG_ERROR;
  if (const absl::Status status = corbslam::tests::Run(flags); !status.ok()) {
    std::fprintf(stderr, "long_mission: %s\n", status.ToString().c_str());
    return 1;
  }
  return 0;
}
