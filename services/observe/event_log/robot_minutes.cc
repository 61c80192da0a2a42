#include "services/observe/event_log/robot_minutes.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/server/process_usage.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::UploadStatus;

namespace {

std::string MiB(uint64_t bytes) {
  return absl::StrFormat("%.1f MiB", static_cast<double>(bytes) / (1 << 20));
}

std::string DescribeState(TrackingState state) {
  switch (state) {
    case TrackingState::kNotInitialised:
      return "waiting for a first frame with depth";
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kLost:
      return "lost";
  }
  return "";
}

std::string DescribeActivity(const AgentReport& report, TrackingState state) {
  switch (report.activity) {
    case AgentActivity::kFinished:
      return "finished: the source has ended";
    case AgentActivity::kWaiting:
      return report.frames == 0 ? "waiting: no frame has come yet"
                                : absl::StrFormat("waiting: no frame for %.0f s, %s until then",
                                                  report.newest_frame_age_s, DescribeState(state));
    default:
      return DescribeState(state);
  }
}

std::string DescribeOutbox(const UploadStatus& upload) {
  return absl::StrCat(
      upload.batches, " batches wait (", MiB(upload.memory_bytes), " in memory, ",
      MiB(upload.spool_bytes), " on disk)",
      upload.frames == 0 ? "" : absl::StrCat(", ", upload.frames, " frames of the trajectory wait"),
      upload.room.ok() ? "" : absl::StrCat(", ", upload.room.message()));
}

// Returns what is wrong with the link, to be said before all else; empty if nothing is.
std::string DescribeTrouble(const RobotMinute& minute) {
  if (!minute.link.has_value() || minute.link->ok()) return "";
  return absl::StrCat("not connected: ", minute.link->message(), "; ");
}

std::string DescribeLink(const RobotMinute& minute) {
  if (!minute.link.has_value()) return "no map store";
  return absl::StrCat(minute.link->ok() ? "connected, " : "", DescribeOutbox(minute.status.upload));
}

}  // namespace

void FrameTally::OnTracked(const TrackingResult& result, absl::Duration /*took*/) {
  absl::MutexLock lock(&mutex_);
  ++counts_.frames;
  if (result.state != TrackingState::kTracking) return;
  ++counts_.tracked;
  points_.push_back(result.points_matched);
}

void FrameTally::SetDropped(uint64_t frames) {
  absl::MutexLock lock(&mutex_);
  dropped_ = frames;
}

FrameCounts FrameTally::Take() {
  absl::MutexLock lock(&mutex_);
  FrameCounts counts = std::exchange(counts_, FrameCounts());
  counts.dropped = dropped_ - std::exchange(dropped_before_, dropped_);
  if (!points_.empty()) {
    const auto middle = points_.begin() + static_cast<std::ptrdiff_t>(points_.size() / 2);
    std::nth_element(points_.begin(), middle, points_.end());
    counts.median_points = *middle;
    points_.clear();
  }
  return counts;
}

std::string FormatMinute(const RobotMinute& minute) {
  const FrameCounts& frames = minute.frames;
  const AgentStatus& status = minute.status;
  const double seconds = absl::ToDoubleSeconds(minute.took);
  std::string line =
      absl::StrFormat("%s%s; %s%.1f frames/s: %d of %d tracked, %d dropped",
                      minute.report.has_value() ? DescribeActivity(*minute.report, status.state)
                                                : DescribeState(status.state),
                      minute.localise_only ? " (it only localises)" : "", DescribeTrouble(minute),
                      seconds > 0 ? static_cast<double>(frames.frames) / seconds : 0.0,
                      frames.tracked, frames.frames, frames.dropped);
  if (frames.median_points.has_value()) {
    absl::StrAppend(&line, ", ", *frames.median_points, " points in the median frame");
  }
  absl::StrAppend(&line, "; ", status.keyframes, " keyframes in ", status.local_maps,
                  status.local_maps == 1 ? " local map" : " local maps", "; ", DescribeLink(minute),
                  "; memory ", MiB(minute.rss_bytes));
  return line;
}

RobotMinutes::RobotMinutes(const Agent* agent, FrameTally* tally, RobotMinutesOptions options)
    : agent_(*agent),
      tally_(*tally),
      session_(std::move(options.session)),
      activity_(std::move(options.activity)),
      localise_only_(options.localise_only),
      log_([this](absl::Duration took) { return MakeLine(took); }, std::move(options.who),
           options.every) {}

std::string RobotMinutes::MakeLine(absl::Duration took) {
  RobotMinute minute{took, tally_.Take(), agent_.GetStatus(), std::nullopt, GetRssBytes()};
  if (session_ != nullptr) minute.link = session_();
  if (activity_ != nullptr) minute.report = activity_->Report();
  minute.localise_only = localise_only_;
  return FormatMinute(minute);
}

}  // namespace corbslam::services
