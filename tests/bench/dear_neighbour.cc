// What a robot that keeps to all limits can cost the others of its mission: robots stream real
// batches at the camera's pace to a map_store process with a journal, and beside them one robot
// sends what is as dear as may be (tests/fault/dear_map.h). Prints, of each run, the others'
// acknowledgements without and with it, and what each kind of its batches took; writes JSON.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/started_server.h"
#include "tests/replay/quantile.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::FindProgramBeside;
using services::MakeChannel;
using services::MakeRemoteUplink;
using services::ProcessEnd;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr char kMission[] = "dear";
// The bar: the others' p99 grows to no more than so many times what it was.
constexpr double kBar = 2;

struct Flags {
  std::string source;
  std::string data_dir;
  std::string json;
  size_t victims = 4;
  double keyframes_per_s = 7;
  double seconds = 20;
  int runs = 5;
  double minutes = 30;
  std::vector<std::string> attack;
};

struct Acknowledgements {
  size_t count = 0;
  double p50_ms = 0;
  double p99_ms = 0;
  double slowest_ms = 0;
};

// Of the batches that were due within the span.
Acknowledgements Summarise(const std::vector<std::unique_ptr<ReplayingAgent>>& robots,
                           absl::Time begin, absl::Time end) {
  std::vector<double> ms;
  for (const auto& robot : robots) {
    for (const ReplayLedger::Delay& delay : robot->ledger().delays) {
      if (begin <= delay.due && delay.due < end) ms.push_back(delay.ms());
    }
  }
  return {ms.size(), Quantile(ms, 0.5), Quantile(ms, 0.99), Quantile(ms, 1)};
}

absl::StatusOr<StartedServer> StartStore(const Flags& flags) {
  fs::remove_all(flags.data_dir);
  return StartServer("map_store", {"--data-dir", flags.data_dir}, flags.data_dir + ".log");
}

// As many laps as they can make: the caller stops them.
std::vector<std::unique_ptr<ReplayingAgent>> StartVictims(const Flags& flags,
                                                          const std::string& address,
                                                          const RecordedUploads& uploads) {
  std::vector<std::unique_ptr<ReplayingAgent>> robots;
  for (size_t i = 0; i < flags.victims; ++i) {
    ReplayOptions options = OptionsOfOne(kMission, i, flags.victims, flags.keyframes_per_s);
    options.local_map = LocalMapId{0x1000 * (i + 1)};
    options.laps = 0x800;
    // Who waits longer than this many batches would be out of step for reasons of its own.
    options.max_waiting = 1000;
    robots.push_back(std::make_unique<ReplayingAgent>(options, &uploads,
                                                      MakeRemoteUplink(MakeChannel(address))));
  }
  return robots;
}

// Until all that was due by now is acknowledged, too: the slowest are the ones that count.
absl::Status WaitUntilAnswered(const std::vector<std::unique_ptr<ReplayingAgent>>& robots,
                               absl::Time due) {
  for (const auto& robot : robots) {
    const absl::Time deadline = absl::Now() + absl::Minutes(10);
    while (robot->ledger().delays.empty() || robot->ledger().delays.back().due < due) {
      if (absl::Now() > deadline) return absl::DeadlineExceededError("a robot is not answered");
      absl::SleepFor(absl::Milliseconds(50));
    }
    if (robot->ledger().sessions != 1) return absl::AbortedError("a robot was thrown out");
  }
  return absl::OkStatus();
}

absl::StatusOr<Acknowledgements> MeasureAlone(const Flags& flags, const RecordedUploads& uploads) {
  ASSIGN_OR_RETURN(const StartedServer store, StartStore(flags));
  const auto robots = StartVictims(flags, store.address, uploads);
  const absl::Time begin = absl::Now() + absl::Seconds(2);
  const absl::Time end = begin + absl::Seconds(flags.seconds);
  absl::SleepFor(end - absl::Now());
  RETURN_IF_ERROR(WaitUntilAnswered(robots, end));
  return Summarise(robots, begin, end);
}

struct Attacked {
  Acknowledgements victims;
  Json log;
  double store_cpu_cores = 0;
  double peak_rss_mb = 0;
};

absl::StatusOr<Json> Attack(const Flags& flags, const std::string& address) {
  ASSIGN_OR_RETURN(const std::string path, FindProgramBeside("dear_attacker"));
  const std::string out = flags.data_dir + ".attack.json";
  std::vector<std::string> command = {path, address, kMission, "--out", out};
  command.insert(command.end(), flags.attack.begin(), flags.attack.end());
  ASSIGN_OR_RETURN(const auto attacker,
                   ChildProcess::Start("dear_attacker", command, flags.data_dir + ".attacker.log"));
  if (!attacker->WaitForEnd(absl::Minutes(flags.minutes))) {
    return absl::DeadlineExceededError(
        absl::StrCat("the attack is not over after ", flags.minutes, " minutes"));
  }
  RETURN_IF_ERROR(attacker->EndStatus());
  Json log = Json::parse(std::ifstream(out), nullptr, false);
  if (log.is_discarded()) return absl::DataLossError(out + " is no JSON");
  return log;
}

absl::StatusOr<Attacked> MeasureAttacked(const Flags& flags, const RecordedUploads& uploads) {
  ASSIGN_OR_RETURN(const StartedServer store, StartStore(flags));
  const absl::Time started = absl::Now();
  auto robots = StartVictims(flags, store.address, uploads);
  absl::SleepFor(absl::Seconds(2));
  Attacked attacked;
  ASSIGN_OR_RETURN(attacked.log, Attack(flags, store.address));
  const auto time = [&](const char* key) {
    return absl::UnixEpoch() + absl::Seconds(attacked.log[key].get<double>());
  };
  RETURN_IF_ERROR(WaitUntilAnswered(robots, time("ended")));
  attacked.victims = Summarise(robots, time("began"), time("ended"));
  robots.clear();
  const double seconds = absl::ToDoubleSeconds(absl::Now() - started);
  const ProcessEnd ended = store.process->Stop(kStopTimeout);
  if (ended.exit_code != 0) return absl::InternalError("the map store did not end well");
  attacked.store_cpu_cores = ended.cpu_s / seconds;
  attacked.peak_rss_mb = ended.peak_rss_mb;
  return attacked;
}

Json ToJson(const Acknowledgements& acknowledgements) {
  return {{"acknowledgements", acknowledgements.count},
          {"p50_ms", acknowledgements.p50_ms},
          {"p99_ms", acknowledgements.p99_ms},
          {"slowest_ms", acknowledgements.slowest_ms}};
}

void Print(int run, const Acknowledgements& alone, const Attacked& attacked) {
  std::printf("| %3d | %7.1f | %7.1f | %7.1f | %7.1f | %8.0f | %6.1f | %6.2f | %6.0f |\n", run,
              alone.p50_ms, alone.p99_ms, attacked.victims.p50_ms, attacked.victims.p99_ms,
              attacked.victims.slowest_ms, attacked.victims.p99_ms / alone.p99_ms,
              attacked.store_cpu_cores, attacked.peak_rss_mb);
  std::fflush(stdout);
}

// The slowest acknowledgement of each kind of the attacker's own batches, over all runs.
void PrintKinds(const Json& runs) {
  struct Kind {
    size_t items = 0;
    double slowest_s = 0;
  };
  std::map<std::string, Kind> kinds;
  for (const Json& run : runs) {
    for (const Json& batch : run["attack"]["batches"]) {
      Kind& kind = kinds[batch["kind"]];
      kind.items = std::max(kind.items, batch["items"].get<size_t>());
      kind.slowest_s =
          std::max(kind.slowest_s, batch["ended"].get<double>() - batch["began"].get<double>());
    }
  }
  std::printf("\n| the attacker's batches | items | slowest, s |\n| --- | --- | --- |\n");
  for (const auto& [name, kind] : kinds) {
    std::printf("| %s | %zu | %.2f |\n", name.c_str(), kind.items, kind.slowest_s);
  }
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::vector<RecordedUploads> recorded, RecordAll({flags.source}));
  std::printf(
      "| run | alone: p50, ms | p99, ms | attacked: p50, ms | p99, ms | slowest, ms | p99 ratio | "
      "store, cores | MB |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  Json runs = Json::array();
  int within = 0;
  for (int run = 1; run <= flags.runs; ++run) {
    ASSIGN_OR_RETURN(const Acknowledgements alone, MeasureAlone(flags, recorded.front()));
    ASSIGN_OR_RETURN(const Attacked attacked, MeasureAttacked(flags, recorded.front()));
    Print(run, alone, attacked);
    within += attacked.victims.p99_ms <= kBar * alone.p99_ms ? 1 : 0;
    runs.push_back({{"alone", ToJson(alone)},
                    {"attacked", ToJson(attacked.victims)},
                    {"store_cpu_cores", attacked.store_cpu_cores},
                    {"store_peak_rss_mb", attacked.peak_rss_mb},
                    {"attack", attacked.log}});
  }
  PrintKinds(runs);
  std::printf("\np99 within %g times in %d of %d runs\n", kBar, within, flags.runs);
  fs::remove_all(flags.data_dir);
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({Json{{"source", flags.source},
                          {"victims", flags.victims},
                          {"runs_within_bar", within},
                          {"runs", runs}}
                         .dump(2)},
                    flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("What a dear robot costs the others of its mission", "dear_neighbour");
  app.add_option("--source", flags.source, "What the others have seen: tum:DIR, ...")->required();
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal; made new, then removed")
      ->required();
  app.add_option("--victims", flags.victims, "The others")->capture_default_str();
  app.add_option("--pace", flags.keyframes_per_s, "Keyframes a second of each")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seconds", flags.seconds, "Of each run without the attacker")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--runs", flags.runs, "Each with a store of its own")->capture_default_str();
  app.add_option("--minutes", flags.minutes, "An attack may take at most")->capture_default_str();
  app.add_option("attack", flags.attack, "Options of dear_attacker, after --");
  app.add_option("--json", flags.json, "File for the runs");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "dear_neighbour: %s\n", status.ToString().c_str());
  return 1;
}
