#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "services/command_line/command_line.h"
#include "services/programs/recording/recording.h"
#include "services/programs/recording/recording_files.h"
#include "services/programs/robot/agent_trajectories.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/progress.h"
#include "services/tool/output/result.h"
#include "services/tool/replay/comparison.h"
#include "services/tool/replay/replay.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

struct ReplayArguments {
  std::string folder;
  std::string trajectory;
  std::string vocabulary;
};

constexpr size_t kNotesShown = 10;

void SayNotes(const std::vector<std::string>& notes) {
  for (size_t i = 0; i < notes.size() && i < kNotesShown; ++i) {
    Say(absl::StrCat("note: ", notes[i], "\n"));
  }
  if (notes.size() > kNotesShown) {
    Say(absl::StrCat("note: and ", notes.size() - kNotesShown, " more\n"));
  }
}

void SayStart(const Recording& recording) {
  const RecordingHead& head = recording.head;
  Say(absl::StrCat(
      recording.folder, ": ", recording.frames.size(), " frames of ", head.source, ", recorded ",
      head.started, " by ", head.version, " at --pace ", head.flags.pace,
      head.flags.localise_only ? ", of a robot that only localised" : "", "; ", head.counts.dropped,
      " more were dropped, ", head.counts.left_out, " tracked and left out of the recording\n"));
  SayNotes(recording.notes);
  if (!recording.frames.empty() && !recording.frames.back().result.has_value()) {
    Say(absl::StrCat("note: the robot ended in frame ", recording.frames.back().line.frame,
                     ", which is played too\n"));
  }
}

nlohmann::ordered_json ToJson(const Recording& recording, const Replayed& replayed,
                              const ReplayComparison& comparison) {
  const auto number = [](const std::optional<size_t>& value) {
    return value.has_value() ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
  };
  const auto difference = [](const std::optional<PoseDifference>& pose) {
    if (!pose.has_value()) return nlohmann::ordered_json();
    return nlohmann::ordered_json{
        {"frame", pose->frame}, {"position_m", pose->position_m}, {"angle_deg", pose->angle_deg}};
  };
  return {{"recording", recording.folder},
          {"source", recording.head.source},
          {"frames", recording.frames.size()},
          {"compared", comparison.compared},
          {"equal", comparison.equal},
          {"first_different", number(comparison.first_different)},
          {"first_pose", difference(comparison.first_pose)},
          {"largest_pose", difference(comparison.largest_pose)},
          {"digest", absl::StrFormat("%016x", DigestOf(replayed.results))},
          {"reasons_to_differ", comparison.AllEqual()
                                    ? std::vector<std::string>()
                                    : ReasonsToDiffer(recording, replayed, ProgramVersion())},
          {"notes", recording.notes}};
}

// Says how the two runs compare. An error: they differ, and nothing explains that.
absl::Status Judge(const Recording& recording, const Replayed& replayed) {
  const ReplayComparison comparison = CompareResults(ResultsOf(recording), replayed.results);
  PrintResult(absl::StrFormat("%sdigest of the replayed poses: %016x, the same each time\n",
                              FormatComparison(comparison), DigestOf(replayed.results)),
              ToJson(recording, replayed, comparison));
  if (comparison.AllEqual()) {
    SayNotes(replayed.notes);
    return absl::OkStatus();
  }
  const std::vector<std::string> reasons = ReasonsToDiffer(recording, replayed, ProgramVersion());
  if (reasons.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "frame ", *comparison.first_different,
        " differs from what was recorded in lockstep by the same program: another kind of "
        "processor computes other last digits; on the same one this is a fault of the program"));
  }
  Say("they may differ:\n");
  SayNotes(reasons);
  return absl::OkStatus();
}

absl::Status Run(const ReplayArguments& arguments) {
  ASSIGN_OR_RETURN(const Recording recording, ReadRecording(arguments.folder));
  SayStart(recording);
  ReplayOptions options;
  options.vocabulary_path = arguments.vocabulary;
  ProgressLine progress;
  const absl::Time start = absl::Now();
  options.on_progress = [&progress, start](size_t done, size_t all) {
    progress.Tell(DescribeCount(done, all, "frames", absl::Now() - start));
  };
  ASSIGN_OR_RETURN(const Replayed replayed, Replay(recording, options));
  if (!arguments.trajectory.empty()) {
    RETURN_IF_ERROR(WriteAgentTrajectories(*replayed.agent, recording.head.calibration,
                                           PosesOf::kRecordedCamera, arguments.trajectory));
  }
  return Judge(recording, replayed);
}

}  // namespace

void AddReplayCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* replay = app.add_subcommand(
      "replay", "Play again what client_agent --record wrote, and compare the poses");
  replay->add_option("folder", arguments->folder, "The recording")->required();
  replay->add_option("--trajectory", arguments->trajectory,
                     "File for the replayed trajectory, as client_agent writes it");
  replay->add_option("--vocabulary", arguments->vocabulary, "Instead of the one that ships");
  replay->callback([arguments, &chosen] { chosen = [arguments] { return Run(*arguments); }; });
}

}  // namespace corbslam::services
