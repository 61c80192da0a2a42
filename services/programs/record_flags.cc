#include "services/programs/record_flags.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "services/command_line/command_line.h"
#include "services/command_line/setting.h"
#include "services/programs/checks.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FrameStream;

namespace {

RecordingHead HeadOf(const RunToRecord& run, const FrameStream& stream) {
  RecordingHead head;
  head.version = ProgramVersion();
  head.source = run.source;
  head.started = absl::FormatTime(absl::RFC3339_sec, absl::Now(), absl::UTCTimeZone());
  head.flags.mission = run.agent.mission;
  head.flags.agent = run.agent.name;
  head.flags.seed = run.agent.seed;
  head.flags.features = run.agent.sensor.orb.features;
  head.flags.solver_threads = run.agent.solver_threads;
  head.flags.pace = NameOf(kPaces, run.pace);
  head.flags.joined = run.joined;
  head.flags.vocabulary = run.vocabulary;
  head.flags.localise_only = run.agent.localise_only;
  head.flags.resumes = run.agent.resume;
  head.flags.max_map_bytes = run.agent.max_map_bytes;
  head.calibration = stream.calibration();
  return head;
}

// A service starts again and again with the same flags: {time} gives each start a folder of its
// own.
std::string FolderOf(const RecordFlags& flags, absl::Time now) {
  return absl::StrReplaceAll(
      flags.folder, {{"{time}", absl::FormatTime("%Y%m%dT%H%M%SZ", now, absl::UTCTimeZone())}});
}

}  // namespace

void AddRecordFlags(CLI::App& app, RecordFlags& flags) {
  AddSettings(
      app,
      {
          {"--record", &flags.folder,
           "New folder for the frames that are tracked and what came of them, for corbslam replay; "
           "{time} in its name becomes that of the start",
           kRare},
          {"--record-mb", &flags.waiting_mb,
           "MiB of frames that wait for --record's disk; more are left out of the recording",
           RareWithin(1, 1 << 20)},
      });
}

absl::Status CheckRecording(const RecordFlags& flags) {
  if (flags.folder.empty()) return absl::OkStatus();
  const std::string folder = FolderOf(flags, absl::Now());
  if (const size_t at = folder.find('{'); at != std::string::npos) {
    return absl::InvalidArgumentError(absl::StrCat("--record: ", flags.folder, ": ",
                                                   folder.substr(at, folder.find('}', at) - at + 1),
                                                   " is no field that is known: {time} is"));
  }
  if (const absl::Status status = CheckRecordingFolder(folder); !status.ok()) {
    return absl::Status(status.code(), absl::StrCat("--record: ", status.message()));
  }
  return CheckFolder("--record", folder);
}

absl::StatusOr<std::unique_ptr<FrameRecorder>> StartRecording(const RecordFlags& flags,
                                                              const RunToRecord& run,
                                                              const FrameStream& stream) {
  if (flags.folder.empty()) return nullptr;
  RecorderOptions options;
  options.max_waiting_bytes = flags.waiting_mb << 20;
  options.waits = run.pace != Pace::kSensor && !stream.is_live();
  if (const auto interval_s = stream.interval_s(); interval_s.has_value() && *interval_s > 0) {
    options.rate_hz = 1 / *interval_s;
  }
  return FrameRecorder::Start(FolderOf(flags, absl::Now()), HeadOf(run, stream), options);
}

}  // namespace corbslam::services
