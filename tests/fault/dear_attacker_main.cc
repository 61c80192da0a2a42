// dear_attacker HOST:PORT MISSION --out FILE: a robot of the mission that sends what is valid and
// as dear to the map store as the limits allow, then what goes beyond them, and writes what became
// of each batch.
#include <glog/logging.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/client/remote/channel.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/fault/awaiting_sender.h"
#include "tests/fault/dear_map.h"

namespace corbslam::tests {

using services::MakeChannel;

namespace {

using Json = nlohmann::ordered_json;

constexpr LocalMapId kLocalMap{0xdea0};

struct Flags {
  std::string address;
  std::string mission;
  DearSizes sizes;
  uint32_t rounds = 1;
  double patience_s = 300;
  std::string out;
};

double NowInSeconds() { return absl::ToDoubleSeconds(absl::Now() - absl::UnixEpoch()); }

// {"began", "ended", "batches": [{"kind", "items", "began", "ended", "end"}], "refused": [{"kind",
// "says", "code", "message"}]}, times in seconds since the epoch. Of the foundation nothing counts:
// "began" is after it.
absl::StatusOr<Json> Attack(const Flags& flags) {
  const absl::Duration patience = absl::Seconds(flags.patience_s);
  const auto channel = MakeChannel(flags.address);
  AwaitingSender sender(channel, flags.mission, "mallory");
  DearMap map(kLocalMap, flags.sizes);
  for (DearBatch& dear : map.Foundation()) {
    RETURN_IF_ERROR(sender.Send(std::move(dear.batch), patience));
  }
  Json log = {{"began", NowInSeconds()}, {"batches", Json::array()}, {"refused", Json::array()}};
  for (uint32_t round = 0; round < flags.rounds; ++round) {
    for (DearBatch& dear : map.Round(round)) {
      Json entry = {{"kind", dear.kind}, {"items", CountItems(dear.batch)}};
      entry["began"] = NowInSeconds();
      const absl::Status end = sender.Send(std::move(dear.batch), patience);
      entry["ended"] = NowInSeconds();
      entry["end"] = absl::StatusCodeToString(end.code());
      LOG(INFO) << dear.kind << " ended with " << end;
      log["batches"].push_back(std::move(entry));
    }
  }
  log["ended"] = NowInSeconds();
  for (DearMap::Refused& refused : map.BeyondLimits()) {
    const absl::Status end = sender.Send(std::move(refused.batch), patience);
    log["refused"].push_back({{"kind", refused.kind},
                              {"says", refused.says},
                              {"code", absl::StatusCodeToString(end.code())},
                              {"message", std::string(end.message())}});
  }
  return log;
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const Json log, Attack(flags));
  return WriteLines({log.dump(2)}, flags.out);
}

void AddSizes(CLI::App& app, DearSizes& sizes) {
  app.add_option("--keyframes", sizes.keyframes, "Of a chain")
      ->check(CLI::Range(10, 100'000))
      ->capture_default_str();
  app.add_option("--crowd", sizes.crowd, "Of them, that see the same points")
      ->check(CLI::Range(2, 100'000))
      ->capture_default_str();
  app.add_option("--reversed", sizes.reversed, "Keyframes of a chain backwards")
      ->check(CLI::Range(2, 100'000))
      ->capture_default_str();
  app.add_option("--wide", sizes.wide_features, "Keypoints of one keyframe")
      ->check(CLI::Range(1, 20'000))
      ->capture_default_str();
  app.add_option("--full", sizes.full_keyframes, "Keyframes of as many in one batch")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--items", sizes.items, "Of a batch at most")
      ->check(CLI::Range(100, 1'000'000))
      ->capture_default_str();
  app.add_option("--parked", sizes.parked, "References that wait; then as many as may")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("A dear robot, to a map store that serves without TLS", "dear_attacker");
  app.add_option("address", flags.address, "HOST:PORT of the map store")->required();
  app.add_option("mission", flags.mission, "The robots' mission")->required();
  corbslam::tests::AddSizes(app, flags.sizes);
  app.add_option("--rounds", flags.rounds, "Of every kind of batch")->capture_default_str();
  app.add_option("--patience", flags.patience_s, "Seconds for an acknowledgement")
      ->capture_default_str();
  app.add_option("--out", flags.out, "File for what became of each batch")->required();
  CLI11_PARSE(app, argc, argv);
  // It has a machine of its own, as it were.
  setpriority(PRIO_PROCESS, 0, 19);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  LOG(ERROR) << status;
  return 1;
}
