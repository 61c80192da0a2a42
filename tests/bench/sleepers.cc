// Measures a store with more missions than its memory holds: how long one takes to wake, what is
// resident, how long a start takes, and what a robot elsewhere notices of missions that wake and
// fall asleep.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"
#include "tests/bench/chain_uploader.h"

namespace corbslam::tests {
namespace {

using map_store::MapStore;
using map_store::RocksJournal;
using Json = nlohmann::ordered_json;

struct Flags {
  std::string data_dir;
  std::string json;
  int missions = 200;
  std::vector<uint32_t> keyframes = {500};
  size_t features = 1500;
  uint64_t budget_bytes = uint64_t{2} << 30;
  int seconds = 60;
  double hz = 10;
  uint64_t min_free_mb = 64;
};

constexpr uint32_t kKeyframesOfABatch = 4;
constexpr char kBusy[] = "busy";

double Mib(uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

// Times in milliseconds, of which some are told.
class Times {
 public:
  void Add(absl::Duration took) { ms_.push_back(absl::ToDoubleMilliseconds(took)); }
  size_t count() const { return ms_.size(); }
  // Returns the time that this share of all is not longer than; 0 if there are none.
  double Quantile(double share) const {
    if (ms_.empty()) return 0;
    std::vector<double> sorted = ms_;
    std::sort(sorted.begin(), sorted.end());
    const auto index = static_cast<size_t>(share * static_cast<double>(sorted.size()));
    return sorted[std::min(index, sorted.size() - 1)];
  }
  Json ToJson() const {
    return {{"count", count()},
            {"p50_ms", Quantile(0.5)},
            {"p99_ms", Quantile(0.99)},
            {"max_ms", Quantile(1)}};
  }
  void Print(const std::string& what) const {
    std::printf("| %s | %zu | %.1f | %.1f | %.1f |\n", what.c_str(), count(), Quantile(0.5),
                Quantile(0.99), Quantile(1));
  }

 private:
  std::vector<double> ms_;
};

uint32_t SizeOf(const Flags& flags, int mission) {
  return flags.keyframes[static_cast<size_t>(mission) % flags.keyframes.size()];
}

std::string NameOf(int mission) { return absl::StrCat("m", mission); }

absl::StatusOr<std::unique_ptr<MapStore>> OpenStore(const Flags& flags) {
  ASSIGN_OR_RETURN(
      std::unique_ptr<RocksJournal> journal,
      RocksJournal::Open({.directory = flags.data_dir, .min_free_bytes = flags.min_free_mb << 20}));
  map_store::MapStoreOptions options;
  options.memory_budget_bytes = flags.budget_bytes;
  // Only want of memory and SleepMission put missions to sleep here.
  options.sleep_after_s = 1e6;
  options.end_s = 600;
  auto store = std::make_unique<MapStore>(options, nullptr, std::move(journal), nullptr);
  RETURN_IF_ERROR(store->Recover());
  return store;
}

absl::Status Fill(const Flags& flags, MapStore& store, uint64_t& most_resident) {
  for (int i = 0; i < flags.missions; ++i) {
    ChainUploader uploader(store, NameOf(i), flags.features);
    RETURN_IF_ERROR(uploader.Open());
    for (uint32_t k = 0; k < SizeOf(flags, i); k += kKeyframesOfABatch) {
      RETURN_IF_ERROR(uploader.Upload(std::min(kKeyframesOfABatch, SizeOf(flags, i) - k)));
    }
    most_resident = std::max(most_resident, ResidentBytes());
  }
  return absl::OkStatus();
}

// Sends keyframes at the robot's pace for as long as is wanted, and says how long each took.
absl::StatusOr<Times> SendAtPace(const Flags& flags, ChainUploader& robot) {
  Times times;
  const absl::Time end = absl::Now() + absl::Seconds(flags.seconds);
  for (absl::Time next = absl::Now(); next < end; next += absl::Seconds(1 / flags.hz)) {
    absl::SleepFor(next - absl::Now());
    const absl::Time begin = absl::Now();
    RETURN_IF_ERROR(robot.Upload(1));
    times.Add(absl::Now() - begin);
  }
  return times;
}

struct Churn {
  std::map<uint32_t, Times> waking;  // By the mission's keyframes.
  int refused = 0;                   // For want of memory.
  uint64_t most_resident = 0;
};

// Wakes one mission after the other, and has each fall asleep again, until it is told to stop.
Churn WakeAndSleep(const Flags& flags, MapStore& store, const std::atomic<bool>& stop) {
  Churn churn;
  for (int i = 0; !stop; i = (i + 1) % flags.missions) {
    store.SleepMission(NameOf(i)).IgnoreError();
    const absl::Time begin = absl::Now();
    const absl::Status woken = store.ListAgents(NameOf(i), {}).status();
    if (woken.ok()) churn.waking[SizeOf(flags, i)].Add(absl::Now() - begin);
    churn.refused += woken.ok() ? 0 : 1;
    churn.most_resident = std::max(churn.most_resident, ResidentBytes());
  }
  return churn;
}

void PrintPlace(const char* what, const Flags& flags, const MapStore& store, double seconds) {
  std::printf("| %s | %.1f | %zu | %.0f | %.0f |\n", what, seconds, store.sleep().asleep,
              Mib(ResidentBytes()), Mib(map_store::BytesIn(flags.data_dir)));
  std::fflush(stdout);
}

absl::StatusOr<std::unique_ptr<MapStore>> FillAndRestart(const Flags& flags, Json& json) {
  std::printf(
      "| what | s | asleep | resident, MiB | disk, MiB |\n| --- | --- | --- | --- | --- |\n");
  ASSIGN_OR_RETURN(std::unique_ptr<MapStore> store, OpenStore(flags));
  const absl::Time begin = absl::Now();
  uint64_t most_resident = 0;
  RETURN_IF_ERROR(Fill(flags, *store, most_resident));
  json["filling_s"] = absl::ToDoubleSeconds(absl::Now() - begin);
  json["filling_most_resident_bytes"] = most_resident;
  PrintPlace("filled", flags, *store, json["filling_s"]);
  const absl::Time ending = absl::Now();
  store.reset();
  json["orderly_end_s"] = absl::ToDoubleSeconds(absl::Now() - ending);
  const absl::Time opening = absl::Now();
  ASSIGN_OR_RETURN(store, OpenStore(flags));
  json["start_s"] = absl::ToDoubleSeconds(absl::Now() - opening);
  json["asleep_after_start"] = store->sleep().asleep;
  json["start_resident_bytes"] = ResidentBytes();
  PrintPlace("started again", flags, *store, json["start_s"]);
  return store;
}

absl::Status MeasureRobot(const Flags& flags, MapStore& store, Json& json) {
  ChainUploader robot(store, kBusy, flags.features);
  RETURN_IF_ERROR(robot.Open());
  ASSIGN_OR_RETURN(const Times alone, SendAtPace(flags, robot));
  std::atomic<bool> stop = false;
  Churn churn;
  std::thread others([&] { churn = WakeAndSleep(flags, store, stop); });
  const absl::StatusOr<Times> beside = SendAtPace(flags, robot);
  stop = true;
  others.join();
  RETURN_IF_ERROR(beside.status());
  std::printf(
      "\n| what | count | p50, ms | p99, ms | most, ms |\n| --- | --- | --- | --- | --- |\n");
  alone.Print("acknowledged, all others asleep");
  beside->Print("acknowledged while others wake and fall asleep");
  json["acknowledged_alone"] = alone.ToJson();
  json["acknowledged_beside"] = beside->ToJson();
  for (const auto& [keyframes, times] : churn.waking) {
    times.Print(absl::StrCat("woken, of ", keyframes, " keyframes"));
    json["waking"][absl::StrCat(keyframes)] = times.ToJson();
  }
  std::printf("\nat most %.0f MiB resident; %d times there was no room to wake\n",
              Mib(churn.most_resident), churn.refused);
  json["waking_most_resident_bytes"] = churn.most_resident;
  json["waking_refused"] = churn.refused;
  return absl::OkStatus();
}

absl::Status Measure(const Flags& flags) {
  Json json = {{"missions", flags.missions},
               {"keyframes", flags.keyframes},
               {"features", flags.features},
               {"budget_bytes", flags.budget_bytes},
               {"robot_keyframes_per_s", flags.hz}};
  ASSIGN_OR_RETURN(const std::unique_ptr<MapStore> store, FillAndRestart(flags, json));
  RETURN_IF_ERROR(MeasureRobot(flags, *store, json));
  if (flags.json.empty()) return absl::OkStatus();
  std::ofstream file(flags.json);
  file << json.dump(2) << "\n";
  file.close();
  return file ? absl::OkStatus() : absl::UnavailableError(absl::StrCat("can't write ", flags.json));
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  using corbslam::tests::Flags;
  Flags flags;
  CLI::App app("Measures a store with more missions than its memory holds");
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal, empty")->required();
  app.add_option("--json", flags.json, "File for the same as JSON");
  app.add_option("--missions", flags.missions, "Missions")->check(CLI::Range(1, 100000));
  app.add_option("--keyframes", flags.keyframes, "Keyframes of missions, in turn")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--features", flags.features, "Features of each keyframe");
  app.add_option("--memory-budget", flags.budget_bytes, "As map_store's; 0: none")
      ->transform(CLI::AsSizeValue(/*kb_is_1000=*/false));
  app.add_option("--seconds", flags.seconds, "How long a robot sends, alone and beside others");
  app.add_option("--hz", flags.hz, "Its keyframes a second")->check(CLI::Range(0.1, 1000.0));
  app.add_option("--min-free-mb", flags.min_free_mb, "As map_store's");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Measure(flags);
  LOG_IF(ERROR, !status.ok()) << status;
  return status.ok() ? 0 : 1;
}
