#include "services/tool/replay/replay.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/agent/agent_orders.h"
#include "client_agent/source/kept_imu.h"
#include "services/programs/default_vocabulary.h"
#include "services/programs/recording/recording_files.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::AgentOrders;
using client_agent::KeptImu;
using client_agent::TrackingResult;

namespace {

constexpr absl::Duration kFinishTimeout = absl::Minutes(10);

AgentOptions OptionsOf(const RecordedFlags& flags) {
  AgentOptions options;
  options.mission = flags.mission;
  options.name = flags.agent;
  options.seed = flags.seed;
  options.deterministic = true;
  options.solver_threads = flags.solver_threads;
  options.sensor.orb.features = flags.features;
  return options;
}

absl::StatusOr<std::shared_ptr<const Vocabulary>> LoadVocabulary(const std::string& path,
                                                                 uint64_t recorded,
                                                                 Replayed& replayed) {
  ASSIGN_OR_RETURN(auto vocabulary,
                   Vocabulary::Load(path.empty() ? DefaultVocabularyPath() : path));
  if (vocabulary->fingerprint() != recorded) {
    replayed.notes.emplace_back(
        "the vocabulary is another one than the robot had: give its own with --vocabulary");
  }
  return vocabulary;
}

// Gives the orders again that were given before a frame.
absl::Status GiveOrders(const Recording& recording, const OrdersLine& line, AgentOrders& orders) {
  RETURN_IF_ERROR(orders.PauseMapping(line.mapping_paused));
  if (line.opens_local_map) RETURN_IF_ERROR(orders.OpenLocalMap());
  if (!line.has_mask.has_value()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const PictureMask mask, ReadOrderedMask(recording, line));
  return orders.SetMask(mask);
}

// Plays one frame. Returns nullopt, with a note, where there are no pictures.
absl::StatusOr<std::optional<TrackingResult>> Play(const Recording& recording,
                                                   const RecordedFrame& recorded,
                                                   AgentOrders& orders, KeptImu& kept_imu,
                                                   Replayed& replayed) {
  const FrameLine& frame = recorded.line;
  if (frame.begins_local_map) replayed.agent->BeginLocalMap();
  if (recorded.orders.has_value()) {
    const absl::Status given = GiveOrders(recording, *recorded.orders, orders);
    if (!given.ok()) {
      replayed.notes.push_back(absl::StrCat("frame ", frame.frame,
                                            ": an order can't be given again: ", given.message()));
    }
  }
  ImuSamples imu = ImuOf(recording, recorded);
  if (frame.pictures.empty()) {
    kept_imu.Keep(/*drive=*/0, std::move(imu));
    replayed.notes.push_back(absl::StrCat("frame ", frame.frame, " was left out when recording"));
    return std::nullopt;
  }
  absl::StatusOr<SensorImages> images = ReadPictures(recording, frame);
  if (!images.ok()) {
    kept_imu.Keep(/*drive=*/0, std::move(imu));
    replayed.notes.push_back(absl::StrCat("frame ", frame.frame, ": ", images.status().message()));
    return std::nullopt;
  }
  images->imu = std::move(imu);
  kept_imu.GiveTo(/*drive=*/0, images->imu);
  ASSIGN_OR_RETURN(const TrackingResult result, replayed.agent->Track(*images));
  return result;
}

// Played by itself, a robot that only localised would map, somewhere else: that is another robot.
absl::Status CheckMapped(const Recording& recording) {
  if (!recording.head.flags.localise_only) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      recording.folder,
      ": the robot made no map: it was tracked in what others had mapped, which a recording does "
      "not hold. With a map store that has that map its frames are played again by client_agent "
      "--localise-only --server HOST:PORT --mission ",
      recording.head.flags.mission, " --source '",
      SourceOfRecording(recording.folder, recording.kind()), "'"));
}

}  // namespace

absl::StatusOr<Replayed> Replay(const Recording& recording, const ReplayOptions& options) {
  Replayed replayed;
  const RecordedFlags& flags = recording.head.flags;
  RETURN_IF_ERROR(CheckMapped(recording));
  ASSIGN_OR_RETURN(const auto vocabulary,
                   LoadVocabulary(options.vocabulary_path, flags.vocabulary, replayed));
  AgentOptions agent = OptionsOf(flags);
  agent.orders = std::make_shared<AgentOrders>();
  ASSIGN_OR_RETURN(replayed.agent, Agent::Create(agent, recording.head.calibration, vocabulary,
                                                 /*uplink=*/nullptr));
  KeptImu kept_imu;  // Of frames without pictures.
  for (const RecordedFrame& frame : recording.frames) {
    ASSIGN_OR_RETURN(const auto result, Play(recording, frame, *agent.orders, kept_imu, replayed));
    replayed.results.push_back(result);
    if (options.on_progress != nullptr) {
      options.on_progress(replayed.results.size(), recording.frames.size());
    }
  }
  RETURN_IF_ERROR(replayed.agent->Finish(kFinishTimeout));
  return replayed;
}

FrameResults ResultsOf(const Recording& recording) {
  FrameResults results;
  for (const RecordedFrame& frame : recording.frames) results.push_back(frame.result);
  return results;
}

std::vector<std::string> ReasonsToDiffer(const Recording& recording, const Replayed& replayed,
                                         const std::string& version) {
  const RecordingHead& head = recording.head;
  std::vector<std::string> reasons = replayed.notes;
  if (head.flags.pace != "step") {
    reasons.push_back(absl::StrCat(
        "it was recorded at --pace ", head.flags.pace,
        ": mapping ran beside tracking, and how far it had come at each frame isn't recorded"));
  }
  if (head.flags.joined) {
    reasons.emplace_back(
        "the robot was joined to a map store: what other robots gave it isn't recorded");
  }
  if (head.flags.resumes) {
    reasons.emplace_back(
        "the robot may have gone on with the map of an earlier process, which isn't recorded");
  }
  if (head.flags.max_map_bytes > 0) {
    reasons.emplace_back(
        "the robot's memory was bounded: where it handed over to a new local map isn't replayed");
  }
  if (head.version != version) {
    reasons.push_back(absl::StrCat("it was recorded by ", head.version, ", this is ", version));
  }
  return reasons;
}

}  // namespace corbslam::services
