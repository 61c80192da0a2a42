// How long one robot's new keyframe takes to reach the others: several robots stream real batches
// at the camera's pace to a map_store process with a journal, a fusion_worker process joins their
// maps, and each keyframe's way is timed from the moment it was due to be uploaded to its arrival,
// with its pose in the global frame, at each other robot. Only what was uploaded after the two were
// joined counts. Prints a table and writes JSON.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/started_server.h"
#include "tests/replay/quantile.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam::tests {

using services::MakeChannel;
using services::MakeRemoteUplink;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Flags {
  std::vector<std::string> sources;
  std::string data_dir;
  std::string json;
  std::vector<size_t> agents = {5};
  double keyframes_per_s = 7;
  double seconds = 30;
};

struct Row {
  size_t agents = 0;
  double keyframes_per_s = 0;
  size_t arrivals = 0;
  double p50_ms = 0;
  double p90_ms = 0;
  double p99_ms = 0;
  double acknowledged_p50_ms = 0;
  double acknowledged_p99_ms = 0;
  double bytes_down_per_s = 0;
  double store_cpu_cores = 0;
  double worker_cpu_cores = 0;
};

// Thread-safe.
class Stopwatch {
 public:
  void NoteSent(const MapUpdateBatch& batch, absl::Time due) {
    absl::MutexLock lock(&mutex_);
    for (const FullKeyframe& keyframe : batch.full_keyframes) due_[keyframe.payload->id] = due;
  }

  void NoteShared(size_t agent, const SharedUpdate& update) {
    const absl::Time now = absl::Now();
    absl::MutexLock lock(&mutex_);
    for (const SharedKeyframe& keyframe : update.keyframes) {
      const KeyframeId id = keyframe.payload->id;
      const auto [joined, first] = joined_.try_emplace({agent, id.local_map}, now);
      const auto due = due_.find(id);
      if (first || due == due_.end() || due->second < joined->second) continue;
      latencies_ms_.push_back(absl::ToDoubleMilliseconds(now - due->second));
    }
  }

  std::vector<double> latencies_ms() const {
    absl::MutexLock lock(&mutex_);
    return latencies_ms_;
  }

 private:
  mutable absl::Mutex mutex_;
  std::map<KeyframeId, absl::Time> due_ ABSL_GUARDED_BY(mutex_);
  // Time at which an agent first heard of another's local map.
  std::map<std::pair<size_t, LocalMapId>, absl::Time> joined_ ABSL_GUARDED_BY(mutex_);
  std::vector<double> latencies_ms_ ABSL_GUARDED_BY(mutex_);
};

struct Services {
  StartedServer worker;
  StartedServer store;
};

absl::StatusOr<Services> StartServices(const std::string& data_dir) {
  Services services;
  ASSIGN_OR_RETURN(services.worker, StartServer("fusion_worker", {}, data_dir + ".worker.log"));
  ASSIGN_OR_RETURN(
      services.store,
      StartServer("map_store", {"--data-dir", data_dir, "--worker", services.worker.address},
                  data_dir + ".log"));
  return services;
}

absl::StatusOr<Row> Measure(const Flags& flags, size_t agents,
                            const std::vector<RecordedUploads>& uploads) {
  fs::remove_all(flags.data_dir);
  ASSIGN_OR_RETURN(const Services services, StartServices(flags.data_dir));
  Stopwatch stopwatch;
  std::vector<std::unique_ptr<ReplayingAgent>> robots;
  const absl::Time begin = absl::Now();
  for (size_t i = 0; i < agents; ++i) {
    ReplayOptions options = OptionsOfOne("latency", i, agents, flags.keyframes_per_s);
    options.on_sent = [&stopwatch](const MapUpdateBatch& batch, absl::Time due) {
      stopwatch.NoteSent(batch, due);
    };
    options.on_shared = [&stopwatch, i](const SharedUpdate& update) {
      stopwatch.NoteShared(i, update);
    };
    robots.push_back(
        std::make_unique<ReplayingAgent>(options, &uploads[i % uploads.size()],
                                         MakeRemoteUplink(MakeChannel(services.store.address))));
  }
  const absl::Time end = begin + absl::Seconds(flags.seconds);
  for (const auto& robot : robots) robot->WaitUntilDone(end - absl::Now()).IgnoreError();
  const double seconds = absl::ToDoubleSeconds(absl::Now() - begin);
  Row row{agents};
  std::vector<double> acknowledged;
  for (const auto& robot : robots) {
    robot->Stop();
    const ReplayLedger ledger = robot->ledger();
    row.keyframes_per_s += static_cast<double>(ledger.keyframes) / seconds;
    row.bytes_down_per_s += static_cast<double>(robot->bytes_down()) / seconds;
    AppendDelays(ledger, acknowledged);
  }
  robots.clear();
  const std::vector<double> latencies = stopwatch.latencies_ms();
  row.arrivals = latencies.size();
  row.p50_ms = Quantile(latencies, 0.5);
  row.p90_ms = Quantile(latencies, 0.9);
  row.p99_ms = Quantile(latencies, 0.99);
  row.acknowledged_p50_ms = Quantile(acknowledged, 0.5);
  row.acknowledged_p99_ms = Quantile(acknowledged, 0.99);
  row.store_cpu_cores = services.store.process->Stop(kStopTimeout).cpu_s / seconds;
  row.worker_cpu_cores = services.worker.process->Stop(kStopTimeout).cpu_s / seconds;
  fs::remove_all(flags.data_dir);
  return row;
}

void Print(const Row& row) {
  std::printf(
      "| %6zu | %11.1f | %8zu | %7.1f | %7.1f | %7.1f | %7.1f | %7.1f | %6.2f | %5.2f | %6.2f |\n",
      row.agents, row.keyframes_per_s, row.arrivals, row.p50_ms, row.p90_ms, row.p99_ms,
      row.acknowledged_p50_ms, row.acknowledged_p99_ms, 1e-6 * row.bytes_down_per_s,
      row.store_cpu_cores, row.worker_cpu_cores);
  std::fflush(stdout);
}

Json ToJson(const Row& row) {
  return {{"agents", row.agents},
          {"keyframes_per_s", row.keyframes_per_s},
          {"arrivals", row.arrivals},
          {"update_p50_ms", row.p50_ms},
          {"update_p90_ms", row.p90_ms},
          {"update_p99_ms", row.p99_ms},
          {"acknowledged_p50_ms", row.acknowledged_p50_ms},
          {"acknowledged_p99_ms", row.acknowledged_p99_ms},
          {"bytes_down_per_s", row.bytes_down_per_s},
          {"store_cpu_cores", row.store_cpu_cores},
          {"worker_cpu_cores", row.worker_cpu_cores}};
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::vector<RecordedUploads> uploads, RecordAll(flags.sources));
  std::printf(
      "| agents | keyframes/s | arrivals | p50, ms | p90, ms | p99, ms | ack p50 | ack p99 | MB/s  "
      " "
      "| store | worker |\n"
      "| ------ | ----------- | -------- | ------- | ------- | ------- | ------- | ------- | "
      "------ "
      "| ----- | ------ |\n");
  Json rows = Json::array();
  for (const size_t agents : flags.agents) {
    ASSIGN_OR_RETURN(const Row row, Measure(flags, agents, uploads));
    Print(row);
    rows.push_back(ToJson(row));
  }
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({Json{{"sources", flags.sources}, {"rows", rows}}.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("From one robot's upload to the others", "update_latency");
  app.add_option("--source", flags.sources,
                 "What the robots have seen: kitti:DIR, sim:WORLD, ...; with several, in turn")
      ->required();
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal; made new, then removed")
      ->required();
  app.add_option("--agents", flags.agents, "Numbers of agents")->capture_default_str();
  app.add_option("--pace", flags.keyframes_per_s, "Keyframes a second of each agent")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seconds", flags.seconds, "Of each row, at most")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "update_latency: %s\n", status.ToString().c_str());
  return 1;
}
