// How much a durable map store takes in: real batches of a recorded robot, streamed by any number
// of robots at the camera's pace or as fast as they are acknowledged, to a map_store process with a
// journal, in a folder or in a database. Prints a table and writes JSON.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/programs/store_journal.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/started_server.h"
#include "tests/replay/quantile.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam::tests {

using services::MakeChannel;
using services::MakeRemoteUplink;
using services::ProcessEnd;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Flags {
  std::string source;
  std::string data_dir;
  std::string journal;
  std::string json;
  std::vector<size_t> agents = {1, 12, 50};
  double keyframes_per_s = 7;
  double seconds = 10;
  int threads = 0;
  std::string store;
};

struct Row {
  size_t agents = 0;
  double pace = 0;  // Keyframes a second of each robot; 0: all they can.
  double keyframes_per_s = 0;
  double bytes_per_s = 0;
  double p50_ms = 0;
  double p99_ms = 0;
  double store_cpu_cores = 0;
  double peak_rss_mb = 0;
};

// Makes the journal empty.
absl::Status Clear(const Flags& flags) {
  fs::remove_all(flags.data_dir);
  if (flags.journal.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(services::OpenedJournal opened,
                   services::OpenJournal({.journal = flags.journal}, 0));
  ASSIGN_OR_RETURN(const std::vector<std::string> missions, opened.journal->ListMissions());
  for (const std::string& mission : missions) {
    RETURN_IF_ERROR(opened.journal->DeleteMission(mission));
  }
  return absl::OkStatus();
}

absl::StatusOr<Row> Measure(const Flags& flags, size_t agents, double pace,
                            const RecordedUploads& uploads) {
  RETURN_IF_ERROR(Clear(flags));
  std::vector<std::string> arguments = {"--data-dir", flags.data_dir};
  if (!flags.journal.empty()) arguments = {"--journal", flags.journal};
  if (flags.threads > 0) {
    arguments.insert(arguments.end(), {"--threads", absl::StrCat(flags.threads)});
  }
  for (const absl::string_view flag : absl::StrSplit(flags.store, ' ', absl::SkipEmpty())) {
    arguments.emplace_back(flag);
  }
  ASSIGN_OR_RETURN(const StartedServer store,
                   StartServer("map_store", arguments, flags.data_dir + ".log"));
  std::vector<std::unique_ptr<ReplayingAgent>> robots;
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  const absl::Time begin = absl::Now();
  for (size_t i = 0; i < agents; ++i) {
    const ReplayOptions options = OptionsOfOne("ingest", i, agents, pace);
    channels.push_back(MakeChannel(store.address));
    robots.push_back(
        std::make_unique<ReplayingAgent>(options, &uploads, MakeRemoteUplink(channels.back())));
  }
  const absl::Time end = begin + absl::Seconds(flags.seconds);
  for (const auto& robot : robots) robot->WaitUntilDone(end - absl::Now()).IgnoreError();
  const double seconds = absl::ToDoubleSeconds(absl::Now() - begin);
  Row row{agents, pace};
  std::vector<double> latencies;
  uint64_t keyframes = 0;
  for (const auto& robot : robots) {
    robot->Stop();
    const ReplayLedger ledger = robot->ledger();
    keyframes += ledger.keyframes;
    row.bytes_per_s += static_cast<double>(robot->bytes_up()) / seconds;
    AppendDelays(ledger, latencies);
  }
  row.keyframes_per_s = static_cast<double>(keyframes) / seconds;
  row.p50_ms = Quantile(latencies, 0.5);
  row.p99_ms = Quantile(latencies, 0.99);
  robots.clear();
  const ProcessEnd ended = store.process->Stop(kStopTimeout);
  row.store_cpu_cores = ended.cpu_s / seconds;
  row.peak_rss_mb = ended.peak_rss_mb;
  RETURN_IF_ERROR(Clear(flags));
  return row;
}

void Print(const Row& row) {
  std::printf("| %6zu | %8s | %11.1f | %6.2f | %8.1f | %8.1f | %6.2f | %8.0f |\n", row.agents,
              row.pace > 0 ? absl::StrCat(row.pace, "/s").c_str() : "all", row.keyframes_per_s,
              1e-6 * row.bytes_per_s, row.p50_ms, row.p99_ms, row.store_cpu_cores, row.peak_rss_mb);
  std::fflush(stdout);
}

Json ToJson(const Row& row) {
  return {{"agents", row.agents},
          {"pace_keyframes_per_s", row.pace},
          {"keyframes_per_s", row.keyframes_per_s},
          {"bytes_per_s", row.bytes_per_s},
          {"acknowledged_p50_ms", row.p50_ms},
          {"acknowledged_p99_ms", row.p99_ms},
          {"store_cpu_cores", row.store_cpu_cores},
          {"store_peak_rss_mb", row.peak_rss_mb}};
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::vector<RecordedUploads> recorded, RecordAll({flags.source}));
  const RecordedUploads& uploads = recorded.front();
  uint64_t keyframes = 0;
  for (const MapUpdateBatch& batch : uploads) keyframes += batch.full_keyframes.size();
  std::printf("%s: %zu batches, %lu keyframes; %g s each\n\n", flags.source.c_str(), uploads.size(),
              static_cast<unsigned long>(keyframes), flags.seconds);
  std::printf(
      "| agents | pace     | keyframes/s | MB/s   | p50, ms  | p99, ms  | cores  | MB       |\n");
  std::printf(
      "| ------ | -------- | ----------- | ------ | -------- | -------- | ------ | -------- |\n");
  Json rows = Json::array();
  for (const double pace : {flags.keyframes_per_s, 0.0}) {
    for (const size_t agents : flags.agents) {
      ASSIGN_OR_RETURN(const Row row, Measure(flags, agents, pace, uploads));
      Print(row);
      rows.push_back(ToJson(row));
    }
  }
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({Json{{"source", flags.source}, {"rows", rows}}.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("Durable ingest of the map store", "durable_ingest");
  app.add_option("--source", flags.source, "What the robots have seen: kitti:DIR, sim:WORLD, ...")
      ->required();
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal; made new, then removed")
      ->required();
  app.add_option("--journal", flags.journal,
                 "The store's --journal instead, whose missions are deleted; --data-dir names its "
                 "log alone");
  app.add_option("--agents", flags.agents, "Numbers of agents")->capture_default_str();
  app.add_option("--pace", flags.keyframes_per_s, "Keyframes a second of each agent")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seconds", flags.seconds, "Of each row, at most")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--threads", flags.threads, "The store's --threads; 0: its default");
  app.add_option("--store", flags.store, "More flags of the store, with spaces between");
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "durable_ingest: %s\n", status.ToString().c_str());
  return 1;
}
