// mortal_robot: a robot without a map store that plays a recording in its own time and keeps what
// it maps in a spool. It writes when which keyframe was made, for whoever kills it.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "absl/time/clock.h"
#include "client_agent/agent/agent.h"
#include "client_agent/source/recorded_sequence.h"
#include "client_agent/spool/testing/unsynced_loss_files.h"
#include "services/programs/default_vocabulary.h"
#include "services/programs/spool_flags.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::OpenSource;
using client_agent::OpenUnsyncedLossFolder;
using client_agent::Spool;
using client_agent::SpoolOptions;
using services::SpoolFlags;

namespace {

struct MortalRobot {
  std::string source;
  std::string keyframes;  // File for "index nanoseconds" of each keyframe.
  SpoolFlags spool;
  std::string ledger;          // What of the spool was synced; empty: nobody wants to know.
  uint64_t segment_bytes = 0;  // 0: as many as a robot's.
};

absl::StatusOr<std::unique_ptr<Spool>> OpenSpoolOf(const MortalRobot& robot) {
  if (robot.ledger.empty()) return OpenSpool(robot.spool, "mortal");
  ASSIGN_OR_RETURN(auto files, OpenUnsyncedLossFolder(robot.spool.folder, robot.ledger));
  SpoolOptions options = SpoolOptionsOf(robot.spool, "mortal");
  if (robot.segment_bytes > 0) options.segment_bytes = robot.segment_bytes;
  return services::OpenSpoolIn(std::move(files), options);
}

absl::StatusOr<std::unique_ptr<Agent>> MakeAgent(const MortalRobot& robot,
                                                 const SensorCalibration& calibration) {
  AgentOptions options;
  const bool stereo = KindOf(calibration) == SensorKind::kStereo;
  options.sensor.orb.features = stereo ? 2000 : 1000;
  options.keep_trajectory = false;
  options.seed = static_cast<uint64_t>(absl::GetCurrentTimeNanos());
  ApplySpoolFlags(robot.spool, options);
  ASSIGN_OR_RETURN(auto vocabulary, Vocabulary::Load(services::DefaultVocabularyPath()));
  ASSIGN_OR_RETURN(auto spool, OpenSpoolOf(robot));
  return Agent::Create(options, calibration, std::move(vocabulary), nullptr, std::move(spool));
}

absl::Status Drive(const MortalRobot& robot) {
  ASSIGN_OR_RETURN(const auto source, OpenSource(robot.source));
  ASSIGN_OR_RETURN(const std::unique_ptr<Agent> agent, MakeAgent(robot, source->calibration()));
  std::FILE* file = std::fopen(robot.keyframes.c_str(), "w");
  if (file == nullptr) return absl::UnavailableError("can't write " + robot.keyframes);
  std::optional<absl::Duration> offset;
  while (true) {
    ASSIGN_OR_RETURN(const auto images, source->NextImages());
    if (!images.has_value()) break;
    const absl::Time taken = absl::FromUnixNanos(images->timestamp_ns);
    offset = offset.value_or(absl::Now() - taken);
    absl::SleepFor(taken + *offset - absl::Now());
    ASSIGN_OR_RETURN(const auto result, agent->Track(*images));
    if (!result.made_keyframe) continue;
    std::fprintf(file, "%u %lld\n", result.reference.index,
                 static_cast<long long>(absl::GetCurrentTimeNanos()));
    std::fflush(file);
  }
  std::fclose(file);
  return agent->Finish(absl::Seconds(60));
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::MortalRobot robot;
  CLI::App app("A robot without a map store that somebody kills", "mortal_robot");
  app.add_option("--source", robot.source, "A recording")->required();
  app.add_option("--keyframes", robot.keyframes, "File for when keyframes were made")->required();
  app.add_option("--ledger", robot.ledger, "File for what of the spool was synced");
  app.add_option("--segment-bytes", robot.segment_bytes, "Bytes of one of the spool's files");
  AddSpoolFlags(app, robot.spool);
  CLI11_PARSE(app, argc, argv);
  const absl::Status driven = corbslam::tests::Drive(robot);
  if (!driven.ok()) LOG(ERROR) << driven;
  return driven.ok() ? 0 : 1;
}
