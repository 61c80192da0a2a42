#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/command_line/command_line.h"
#include "services/programs/recording/recording.h"
#include "services/programs/recording/recording_files.h"
#include "services/programs/robot/agent_trajectories.h"
#include "services/tool/commands/commands.h"
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
    std::printf("note: %s\n", notes[i].c_str());
  }
  if (notes.size() > kNotesShown) {
    std::printf("note: and %zu more\n", notes.size() - kNotesShown);
  }
}

void SayStart(const Recording& recording) {
  const RecordingHead& head = recording.head;
  std::printf("%s: %zu frames of %s, recorded %s by %s at --pace %s; %s\n",
              recording.folder.c_str(), recording.frames.size(), head.source.c_str(),
              head.started.c_str(), head.version.c_str(), head.flags.pace.c_str(),
              absl::StrCat(head.counts.dropped, " more were dropped, ", head.counts.left_out,
                           " tracked and left out of the recording")
                  .c_str());
  SayNotes(recording.notes);
  if (!recording.frames.empty() && !recording.frames.back().result.has_value()) {
    std::printf("note: the robot ended in frame %llu, which is played too\n",
                static_cast<unsigned long long>(recording.frames.back().line.frame));
  }
  std::fflush(stdout);
}

void ShowOnTerminal(size_t done, size_t all) { std::fprintf(stderr, "\r%zu/%zu ", done, all); }

// Says how the two runs compare. An error: they differ, and nothing explains that.
absl::Status Judge(const Recording& recording, const Replayed& replayed) {
  const ReplayComparison comparison = CompareResults(ResultsOf(recording), replayed.results);
  std::printf("%s", FormatComparison(comparison).c_str());
  std::printf("digest of the replayed poses: %016llx, the same each time\n",
              static_cast<unsigned long long>(DigestOf(replayed.results)));
  if (comparison.AllEqual()) return absl::OkStatus();
  const std::vector<std::string> reasons = ReasonsToDiffer(recording, replayed, ProgramVersion());
  if (reasons.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "frame ", *comparison.first_different,
        " differs from what was recorded in lockstep by the same program: another kind of "
        "processor computes other last digits; on the same one this is a fault of the program"));
  }
  std::printf("they may differ:\n");
  SayNotes(reasons);
  return absl::OkStatus();
}

absl::Status Run(const ReplayArguments& arguments) {
  ASSIGN_OR_RETURN(const Recording recording, ReadRecording(arguments.folder));
  SayStart(recording);
  ReplayOptions options;
  options.vocabulary_path = arguments.vocabulary;
  if (isatty(STDERR_FILENO) != 0) options.on_progress = ShowOnTerminal;
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
