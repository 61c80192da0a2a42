// Does the stream stand still while the whole is optimised? Several robots stream real batches at a
// pace to a map_store process with a journal, which has them fused by a fusion_worker process.
// Between the two stands a gate that lets global bundle adjustments through in every second window
// of time and holds them back in the others; all else passes always. Compares the
// acknowledgements of both kinds of windows. Prints a table and writes JSON.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_fusion_worker.h"
#include "services/client/remote/remote_uplink.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/server/server.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/started_server.h"
#include "tests/replay/quantile.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam::tests {

using services::FusionWorkerService;
using services::MakeChannel;
using services::MakeRemoteFusionWorker;
using services::MakeRemoteUplink;
using services::Server;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Flags {
  std::vector<std::string> sources;
  std::string data_dir;
  std::string json;
  size_t agents = 5;
  double keyframes_per_s = 2.5;
  double seconds = 40;
  double window_s = 4;
};

// Windows of equal length, the first quiet, then busy, quiet, ...
class Windows {
 public:
  Windows(absl::Time begin, absl::Duration length) : begin_(begin), length_(length) {}

  // Returns the index of the window of a time that is not before the first one.
  int64_t IndexOf(absl::Time time) const {
    return static_cast<int64_t>(absl::FDivDuration(time - begin_, length_));
  }
  bool IsBusy(absl::Time time) const { return IndexOf(time) % 2 == 1; }

 private:
  const absl::Time begin_;
  const absl::Duration length_;
};

// Holds adjustments back in quiet windows. Thread-safe.
class Gate : public FusionWorker {
 public:
  Gate(std::unique_ptr<FusionWorker> worker, const Windows& windows)
      : worker_(std::move(worker)), windows_(windows) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    return worker_->VerifyOverlap(request, progress);
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override {
    return worker_->FuseMaps(request, progress);
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    while (!windows_.IsBusy(absl::Now())) {
      if (!progress(0)) return absl::CancelledError("not wanted any more");
      absl::SleepFor(absl::Milliseconds(20));
    }
    const absl::Time begin = absl::Now();
    auto result = worker_->AdjustBundle(request, progress);
    absl::MutexLock lock(&mutex_);
    adjusting_ += absl::Now() - begin;
    ++adjustments_;
    largest_ = std::max(largest_, request.view.keyframes().size());
    return result;
  }

  absl::Duration adjusting() const {
    absl::MutexLock lock(&mutex_);
    return adjusting_;
  }
  int adjustments() const {
    absl::MutexLock lock(&mutex_);
    return adjustments_;
  }
  size_t largest() const {
    absl::MutexLock lock(&mutex_);
    return largest_;
  }

 private:
  const std::unique_ptr<FusionWorker> worker_;
  const Windows windows_;
  mutable absl::Mutex mutex_;
  absl::Duration adjusting_ ABSL_GUARDED_BY(mutex_);
  int adjustments_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t largest_ ABSL_GUARDED_BY(mutex_) = 0;  // Number of keyframes.
};

struct Side {
  size_t acknowledged = 0;
  double p50_ms = 0;
  double p99_ms = 0;
  double max_ms = 0;
};

struct Row {
  double keyframes_per_s = 0;
  int adjustments = 0;
  size_t largest = 0;
  double adjusting_share = 0;  // Share of the busy windows' time.
  Side quiet;
  Side busy;
};

// Summarises batches that were due in windows of one kind; the first window, in which nothing is
// joined yet, is left out.
Side Summarise(const std::vector<ReplayLedger>& ledgers, const Windows& windows, bool busy) {
  std::vector<double> after_ms;
  for (const ReplayLedger& ledger : ledgers) {
    for (const ReplayLedger::Delay& delay : ledger.delays) {
      if (windows.IndexOf(delay.due) < 1 || windows.IsBusy(delay.due) != busy) continue;
      after_ms.push_back(delay.ms());
    }
  }
  return {after_ms.size(), Quantile(after_ms, 0.5), Quantile(after_ms, 0.99),
          Quantile(after_ms, 1)};
}

std::vector<std::unique_ptr<ReplayingAgent>> StartRobots(
    const Flags& flags, const std::string& address, const std::vector<RecordedUploads>& uploads) {
  std::vector<std::unique_ptr<ReplayingAgent>> robots;
  for (size_t i = 0; i < flags.agents; ++i) {
    robots.push_back(std::make_unique<ReplayingAgent>(
        OptionsOfOne("ingest", i, flags.agents, flags.keyframes_per_s),
        &uploads[i % uploads.size()], MakeRemoteUplink(MakeChannel(address))));
  }
  return robots;
}

absl::StatusOr<Row> Measure(const Flags& flags, const std::vector<RecordedUploads>& uploads) {
  fs::remove_all(flags.data_dir);
  ASSIGN_OR_RETURN(const StartedServer worker,
                   StartServer("fusion_worker", {}, flags.data_dir + ".worker.log"));
  const absl::Time begin = absl::Now();
  const Windows windows(begin, absl::Seconds(flags.window_s));
  Gate gate(MakeRemoteFusionWorker({MakeChannel(worker.address)}), windows);
  FusionWorkerService service(&gate);
  ASSIGN_OR_RETURN(const std::unique_ptr<Server> server, Server::Start("127.0.0.1:0", {&service}));
  ASSIGN_OR_RETURN(
      const StartedServer store,
      StartServer("map_store", {"--data-dir", flags.data_dir, "--worker", server->address()},
                  flags.data_dir + ".log"));
  const auto robots = StartRobots(flags, store.address, uploads);
  const absl::Time end = begin + absl::Seconds(flags.seconds);
  for (const auto& robot : robots) robot->WaitUntilDone(end - absl::Now()).IgnoreError();
  const absl::Duration took = absl::Now() - begin;
  Row row;
  std::vector<ReplayLedger> ledgers;
  for (const auto& robot : robots) {
    robot->Stop();
    ledgers.push_back(robot->ledger());
    row.keyframes_per_s +=
        static_cast<double>(ledgers.back().keyframes) / absl::ToDoubleSeconds(took);
  }
  row.quiet = Summarise(ledgers, windows, false);
  row.busy = Summarise(ledgers, windows, true);
  row.adjustments = gate.adjustments();
  row.largest = gate.largest();
  row.adjusting_share = 2 * absl::FDivDuration(gate.adjusting(), took);
  store.process->Stop(kStopTimeout);
  server->Shutdown(absl::ZeroDuration());
  worker.process->Stop(kStopTimeout);
  fs::remove_all(flags.data_dir);
  return row;
}

void Print(const Row& row) {
  std::printf("%.1f keyframes/s; %d adjustments of up to %zu keyframes, %.0f %% of the busy time\n",
              row.keyframes_per_s, row.adjustments, row.largest, 100 * row.adjusting_share);
  std::printf(
      "| windows | batches | p50, ms | p99, ms | max, ms |\n"
      "| ------- | ------- | ------- | ------- | ------- |\n");
  const auto print = [](const char* name, const Side& side) {
    std::printf("| %-7s | %7zu | %7.1f | %7.1f | %7.1f |\n", name, side.acknowledged, side.p50_ms,
                side.p99_ms, side.max_ms);
  };
  print("quiet", row.quiet);
  print("busy", row.busy);
  std::printf("p99, busy against quiet: %.2f\n", row.busy.p99_ms / row.quiet.p99_ms);
}

Json ToJson(const Side& side) {
  return {{"batches", side.acknowledged},
          {"p50_ms", side.p50_ms},
          {"p99_ms", side.p99_ms},
          {"max_ms", side.max_ms}};
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::vector<RecordedUploads> uploads, RecordAll(flags.sources));
  ASSIGN_OR_RETURN(const Row row, Measure(flags, uploads));
  Print(row);
  if (flags.json.empty()) return absl::OkStatus();
  const Json json = {{"sources", flags.sources},
                     {"agents", flags.agents},
                     {"keyframes_per_s", row.keyframes_per_s},
                     {"adjustments", row.adjustments},
                     {"largest_adjustment_keyframes", row.largest},
                     {"adjusting_share", row.adjusting_share},
                     {"quiet", ToJson(row.quiet)},
                     {"busy", ToJson(row.busy)}};
  return WriteLines({json.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("Acknowledgements while bundles are adjusted, and while not",
               "ingest_during_adjustment");
  app.add_option("--source", flags.sources,
                 "What the robots have seen: kitti:DIR, sim:WORLD, ...; with several, in turn")
      ->required();
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal; made new, then removed")
      ->required();
  app.add_option("--agents", flags.agents, "Robots")->capture_default_str();
  app.add_option("--pace", flags.keyframes_per_s, "Keyframes a second of each robot")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seconds", flags.seconds, "At most")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--window", flags.window_s, "Seconds of each window")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--json", flags.json, "File for the figures");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "ingest_during_adjustment: %s\n", status.ToString().c_str());
  return 1;
}
