#include "services/programs/agent_run.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/programs/pictures_time.h"
#include "services/programs/source_json.h"
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

nlohmann::ordered_json Spread(const BoundedSample& sample) {
  std::vector<double> values = sample.values();
  if (values.empty()) return {{"median", 0.0}, {"mean", 0.0}, {"p99", 0.0}};
  std::sort(values.begin(), values.end());
  const size_t count = values.size();
  const auto p99 = static_cast<size_t>(std::ceil(0.99 * static_cast<double>(count))) - 1;
  return {{"median", (values[(count - 1) / 2] + values[count / 2]) / 2},
          {"mean", sample.mean()},
          {"p99", values[p99]}};
}

nlohmann::ordered_json ToJson(const HeldBack& held) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (size_t kind = 0; kind < kUpdateKinds; ++kind) {
    json[kUpdateKindNames[kind]] = held.items[kind];
  }
  return json;
}

}  // namespace

namespace {

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

std::string StatisticsJson(const RunStatistics& run, const Agent& agent) {
  using Json = nlohmann::ordered_json;
  const AgentStatus status = agent.GetStatus();
  const AgentTimings timings = agent.GetTimings();
  const Json local_ba = Spread(timings.local_ba_ms);
  const Json statistics = {
      {"name", run.name},
      {"frames", run.played.played + run.played.dropped},
      {"tracked", status.tracked},
      {"dropped", run.played.dropped},
      {"left_out", run.played.left_out},
      {"pictures_s", run.played.time_s},
      {"lost", status.lost},
      {"local_maps", status.local_maps},
      {"first_upload_s", status.first_upload_s ? Json(*status.first_upload_s) : Json(nullptr)},
      {"shared",
       {{"keyframes_held", status.foreign_keyframes},
        {"points_matched_percent", status.foreign_points_percent},
        {"loops_closed", status.foreign_loops_closed}}},
      {"loops_closed", status.loops_closed},
      {"keyframes", status.keyframes},
      {"map_points", status.map_points},
      {"tracking_ms", Spread(timings.tracking_ms)},
      {"local_ba_ms", local_ba["median"]},
      {"local_ba",
       {{"count", timings.local_ba_ms.count()},
        {"mean_ms", local_ba["mean"]},
        {"p99_ms", local_ba["p99"]}}},
      {"peak_rss_mb", static_cast<double>(GetProcessUsage().peak_rss_bytes) / (1 << 20)},
      {"outbox",
       {{"batches", status.upload.batches},
        {"memory_bytes", status.upload.memory_bytes},
        {"spool_bytes", status.upload.spool_bytes},
        {"lost_local_maps", status.upload.lost_local_maps},
        {"refused_items", status.upload.refused_items}}},
      {"held_back", ToJson(status.upload.held_back)},
      {"bytes_up", run.bytes_up},
      {"bytes_down", run.bytes_down},
      {"source_description", ToJson(run.source)},
      {"warnings", ToJson(run.warnings)}};
  return statistics.dump(2) + "\n";
}

}  // namespace corbslam
