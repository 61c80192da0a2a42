#include "services/programs/agent_run.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
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

nlohmann::ordered_json Spread(std::vector<double> values) {
  if (values.empty()) return {{"median", 0.0}, {"mean", 0.0}, {"p99", 0.0}};
  std::sort(values.begin(), values.end());
  const size_t count = values.size();
  const auto p99 = static_cast<size_t>(std::ceil(0.99 * static_cast<double>(count))) - 1;
  return {{"median", (values[(count - 1) / 2] + values[count / 2]) / 2},
          {"mean", std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(count)},
          {"p99", values[p99]}};
}

}  // namespace

absl::Status PlaySource(
    ImageSource& source, Agent& agent, Pace pace, const absl::Notification& stop,
    PlayedFrames& frames,
    const std::function<void(const TrackingResult&, uint64_t dropped)>& on_frame) {
  std::optional<Schedule> schedule;
  for (size_t i = 0; !stop.HasBeenNotified(); ++i) {
    ASSIGN_OR_RETURN(const std::optional<SensorImages> images, source.Next());
    if (!images) break;
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
    ASSIGN_OR_RETURN(const TrackingResult result, agent.Track(*images));
    ++frames.played;
    on_frame(result, frames.dropped);
  }
  return absl::OkStatus();
}

std::string StatisticsJson(const std::string& name, const Agent& agent, const PlayedFrames& played,
                           uint64_t bytes_up, uint64_t bytes_down) {
  using Json = nlohmann::ordered_json;
  const AgentStatus status = agent.GetStatus();
  const AgentTimings timings = agent.GetTimings();
  const Json local_ba = Spread(timings.local_ba_ms);
  const Json statistics = {
      {"name", name},
      {"frames", played.played + played.dropped},
      {"tracked", status.tracked},
      {"dropped", played.dropped},
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
       {{"count", timings.local_ba_ms.size()},
        {"mean_ms", local_ba["mean"]},
        {"p99_ms", local_ba["p99"]}}},
      {"peak_rss_mb", static_cast<double>(GetProcessUsage().peak_rss_bytes) / (1 << 20)},
      {"outbox",
       {{"batches", status.upload.batches},
        {"memory_bytes", status.upload.memory_bytes},
        {"spool_bytes", status.upload.spool_bytes},
        {"lost_local_maps", status.upload.lost_local_maps}}},
      {"bytes_up", bytes_up},
      {"bytes_down", bytes_down}};
  return statistics.dump(2) + "\n";
}

}  // namespace corbslam
