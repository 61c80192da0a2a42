#include "services/programs/robot/agent_run.h"

#include <glog/logging.h>

#include <cstdlib>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/programs/robot/pictures_time.h"
#include "services/server/process_usage.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// When frames are due: in the sequence's own time, from the first one on.
class Schedule {
 public:
  explicit Schedule(const ImageSource& source) : source_(source), start_(absl::Now()) {}

  absl::Time Due(size_t frame) const {
    // A sequence that is played backwards has falling times.
    const int64_t offset_ns =
        std::abs(source_.frame(frame).timestamp_ns - source_.frame(0).timestamp_ns);
    return start_ + absl::Nanoseconds(offset_ns);
  }
  // The next frame is there already: this one would be dropped by a camera's driver.
  bool IsOvertaken(size_t frame, absl::Time now) const {
    return frame + 1 < source_.size() && now >= Due(frame + 1);
  }

 private:
  const ImageSource& source_;
  const absl::Time start_;
};

// Of a source whose Next has just returned: says what it passed over.
void TellLeftOut(const ImageSource& source, PlayedFrames& frames) {
  const LeftOutFrames left_out = source.left_out();
  if (left_out.count == frames.left_out) return;
  LOG(WARNING) << "a frame that can't be read is left out, " << left_out.count
               << " so far: " << left_out.last;
  frames.left_out = left_out.count;
}

// The camera's drive goes on from frame to frame; another drive is another local map.
void FollowDrive(const ImageSource& source, std::optional<int>& drive, Agent& agent) {
  const int of_frame = source.frame(source.position()).drive;
  if (drive.has_value() && *drive != of_frame) {
    LOG(WARNING) << "the source's time jumps back before frame "
                 << source.frame(source.position()).number << ": a new local map begins";
    agent.BeginLocalMap();
  }
  drive = of_frame;
}

}  // namespace

absl::Status PlaySource(
    ImageSource& source, Agent& agent, Pace pace, const absl::Notification& stop,
    PlayedFrames& frames,
    const std::function<void(const TrackingResult&, uint64_t dropped)>& on_frame) {
  std::optional<Schedule> schedule;
  std::optional<int> drive;
  while (!stop.HasBeenNotified()) {
    const absl::StatusOr<std::optional<SensorImages>> images = source.Next();
    TellLeftOut(source, frames);
    RETURN_IF_ERROR(images.status());
    if (!images->has_value()) break;
    const size_t i = source.position();
    // The clock starts when the first picture is decoded.
    if (!schedule) schedule.emplace(source);
    if (pace == Pace::kSensor) {
      const absl::Time now = absl::Now();
      if (schedule->IsOvertaken(i, now)) {
        ++frames.dropped;
        continue;
      }
      if (stop.WaitForNotificationWithTimeout(schedule->Due(i) - now)) break;
    }
    FollowDrive(source, drive, agent);
    ASSIGN_OR_RETURN(const TrackingResult result, agent.Track(**images));
    ++frames.played;
    on_frame(result, frames.dropped);
  }
  return absl::OkStatus();
}

SourceFindings CollectWarnings(const SourceFindings& at_start, const Agent& agent,
                               const ImageSource& source, const PlayedFrames& played) {
  SourceFindings warnings = at_start;
  const AgentStatus status = agent.GetStatus();
  warnings.insert(warnings.end(), status.input_findings.begin(), status.input_findings.end());
  if (const LeftOutFrames left_out = source.left_out(); left_out.count > 0) {
    warnings.push_back({FindingLevel::kWarning, "frames-left-out",
                        absl::StrCat(left_out.count,
                                     " frames could not be read and were left out, "
                                     "the last because of ",
                                     left_out.last)});
  }
  if (status.upload.refused_items > 0) {
    warnings.push_back(
        {FindingLevel::kWarning, "items-refused",
         absl::StrCat(status.upload.refused_items,
                      " items of the map had impossible values and were not told to the map store; "
                      "the log names them")});
  }
  if (status.tracked == 0 && played.played > 0) {
    warnings.push_back(
        {FindingLevel::kWarning, "nothing-tracked",
         absl::StrCat("none of ", played.played,
                      " frames was tracked: there is no map. Ask corbslam doctor --source what is "
                      "wrong with the pictures")});
  }
  return warnings;
}

void AddRun(const ImageSource& source, const PlayedFrames& played, const SourceFindings& warnings,
            RobotReport& report) {
  const uint64_t frames = played.played + played.dropped;
  report.frames = static_cast<int>(frames);
  report.dropped = static_cast<int>(played.dropped);
  report.left_out = static_cast<int>(played.left_out);
  report.pictures_s = PicturesTime_s(source, frames);
  report.warnings = ToReportWarnings(warnings);
  const ProcessUsage usage = GetProcessUsage();
  report.peak_rss_mb = static_cast<double>(usage.peak_rss_bytes) / (1 << 20);
  report.cpu_s = usage.cpu_s;
}

}  // namespace corbslam
