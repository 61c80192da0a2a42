// attacker HOST:PORT MISSION --out FILE: does everything that a hostile client may do to a map
// store and to its metrics port while robots stream, one attack after the other, and writes how
// each of them ended.
#include <glog/logging.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/client/remote/channel.h"
#include "services/client/store/store_reader.h"
#include "services/programs/default_vocabulary.h"
#include "slam/vocabulary/vocabulary.h"
#include "tests/fault/attacks.h"
#include "tests/fault/metrics_attacks.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

using services::DefaultVocabularyPath;
using services::MakeChannel;
using services::StoreReader;

namespace {

constexpr absl::Duration kPatience = absl::Seconds(40);

struct Flags {
  std::string address;
  std::string metrics;
  std::string mission;
  uint64_t victim = 0;
  int messages = 0;
  int calls = 0;
  std::string source;
  std::string out;
};

double NowInSeconds() { return absl::ToDoubleSeconds(absl::Now() - absl::UnixEpoch()); }

// {"began", "ended", "attacks": [{"name", "began", "ended", "ends": {CODE: calls},
// "own_keyframes"}]}, times in seconds since the epoch. "own_keyframes" is what the store has of
// the attacker's, where that can be asked.
class AttackLog {
 public:
  explicit AttackLog(const std::string& address)
      : own_(MakeChannel(address), Attacker::kOwnMission) {}

  void Do(const std::string& name, const std::function<Attacker::Ends()>& attack) {
    nlohmann::json entry = {{"name", name}, {"began", NowInSeconds()}};
    entry["ends"] = attack();
    entry["ended"] = NowInSeconds();
    const auto statistics = own_.Statistics();
    if (statistics.ok()) entry["own_keyframes"] = statistics->mission().keyframes();
    // The mission is not found when nothing was written to it and its last session has ended.
    if (absl::IsNotFound(statistics.status())) entry["own_keyframes"] = 0;
    attacks_.push_back(std::move(entry));
  }

  nlohmann::json Take() {
    const double began = attacks_.front()["began"];
    const double ended = attacks_.back()["ended"];
    return {{"began", began}, {"ended", ended}, {"attacks", std::move(attacks_)}};
  }

 private:
  StoreReader own_;
  nlohmann::json attacks_ = nlohmann::json::array();
};

void AttackMetrics(const Flags& flags, AttackLog& log) {
  MetricsAttacker attacker(flags.metrics, 2);
  log.Do("metrics: every request", [&] { return attacker.AskForEverything(); });
  log.Do("metrics: mutated requests", [&] { return attacker.SendMutatedRequests(flags.messages); });
  log.Do("metrics: connections that are slow",
         [&] { return attacker.HoldConnections(flags.calls, kPatience); });
  log.Do("metrics: connections that go", [&] { return attacker.OpenAndClose(flags.messages); });
  log.Do("metrics: answers that nobody reads",
         [&] { return attacker.ScrapeWithoutReading(flags.calls, kPatience); });
}

nlohmann::json DoEverything(const Flags& flags, const RecordedUploads& uploads) {
  Attacker attacker(flags.address, flags.mission, LocalMapId{flags.victim}, &uploads, 1);
  AttackLog log(flags.address);
  log.Do("forbidden batches", [&] {
    Attacker::Ends ends;
    for (const auto& [what, end] : attacker.SendForbiddenBatches()) {
      LOG(INFO) << what << " ended with " << end;
      ++ends[end];
    }
    return ends;
  });
  log.Do("a number again and again", [&] { return attacker.ReplayANumber(20); });
  log.Do("a claim of 2 GB", [&] { return attacker.ClaimTwoGigabytes(kPatience); });
  log.Do("a message byte by byte", [&] { return attacker.Dribble(kPatience); });
  for (const std::string method : {"Sync", "RestoreMission"}) {
    log.Do("silent streams: " + method,
           [&] { return attacker.OpenSilentStreams(method, flags.calls, kPatience); });
  }
  log.Do("look-ups", [&] { return attacker.FloodWithLookups(flags.calls, kPatience); });
  log.Do("mutated messages", [&] { return attacker.SendMutatedMessages(flags.messages); });
  AttackMetrics(flags, log);
  return log.Take();
}

absl::Status Run(const Flags& flags) {
  const auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
  if (!vocabulary.ok()) return vocabulary.status();
  const auto uploads = RecordUploads(flags.source, *vocabulary);
  if (!uploads.ok()) return uploads.status();
  std::ofstream out(flags.out);
  out << DoEverything(flags, *uploads).dump(2);
  out.close();
  return out ? absl::OkStatus() : absl::UnavailableError(flags.out + " can't be written");
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("Attacks a map store that serves without TLS", "attacker");
  app.add_option("address", flags.address, "HOST:PORT of the map store")->required();
  app.add_option("mission", flags.mission, "The robots' mission")->required();
  app.add_option("--metrics", flags.metrics, "IP:PORT of its metrics")->required();
  app.add_option("--victim", flags.victim, "Local map that a robot uploads now")->required();
  app.add_option("--source", flags.source, "A recording for good batches")->required();
  app.add_option("--messages", flags.messages, "Mutated messages")->required();
  app.add_option("--calls", flags.calls, "Calls of each flood")->required();
  app.add_option("--out", flags.out, "File for how each attack ended")->required();
  CLI11_PARSE(app, argc, argv);
  // The attacker runs at the lowest priority: in the field it would compute on a machine of its
  // own.
  setpriority(PRIO_PROCESS, 0, 19);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  LOG(ERROR) << status;
  return 1;
}
