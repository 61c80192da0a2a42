// Writes how a robot fares to its log, a line a minute.
#ifndef CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_ROBOT_MINUTES_H_
#define CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_ROBOT_MINUTES_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/agent/activity_watch.h"
#include "client_agent/agent/agent.h"
#include "services/observe/event_log/minute_log.h"
#include "services/observe/logging/log_fields.h"
#include "services/observe/observed_agent.h"

namespace corbslam::services {

// Counts of the frames since the last line.
struct FrameCounts {
  uint64_t frames = 0;
  uint64_t tracked = 0;
  uint64_t dropped = 0;  // They came too fast.
  // Map points that agreed with a tracked frame's pose: the median; nullopt where none was tracked.
  std::optional<int> median_points;
};

// Counts frames as they are tracked. Thread-safe.
class FrameTally : public FrameObserver {
 public:
  void OnFrame(int64_t /*timestamp_ns*/) override {}
  void OnTracked(const client_agent::TrackingResult& result, absl::Duration took) override;
  // Tells how many frames were dropped since the beginning.
  void SetDropped(uint64_t frames);
  // Returns the counts since the last call.
  FrameCounts Take();

 private:
  absl::Mutex mutex_;
  FrameCounts counts_ ABSL_GUARDED_BY(mutex_);
  std::vector<int> points_ ABSL_GUARDED_BY(mutex_);
  uint64_t dropped_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t dropped_before_ ABSL_GUARDED_BY(mutex_) = 0;
};

struct RobotMinute {
  absl::Duration took;  // Time that the counts are of.
  FrameCounts frames;
  client_agent::AgentStatus status;
  // Whether a session with the map store stands, or why not; nullopt: the robot has no store.
  std::optional<absl::Status> link;
  uint64_t rss_bytes = 0;
  // What the robot is doing; nullopt: its tracking alone says that.
  std::optional<AgentReport> report = std::nullopt;
  bool localise_only = false;
};
// Returns the line: what the robot is at and what is wrong with its link first, then counts.
std::string FormatMinute(const RobotMinute& minute);

struct RobotMinutesOptions {
  LogFields who;
  absl::Duration every = absl::Minutes(1);
  // Says why no session stands; null: there is no store.
  std::function<absl::Status()> session;
  std::shared_ptr<const client_agent::ActivityWatch> activity;  // Null: RobotMinute::report.
  bool localise_only = false;
};

// Writes the lines from a thread of its own, also while no frame comes. Thread-safe.
class RobotMinutes {
 public:
  // `agent` and `tally` are not owned and outlive it.
  RobotMinutes(const client_agent::Agent* agent, FrameTally* tally, RobotMinutesOptions options);

 private:
  std::string MakeLine(absl::Duration took);

  const client_agent::Agent& agent_;
  FrameTally& tally_;
  const std::function<absl::Status()> session_;
  const std::shared_ptr<const client_agent::ActivityWatch> activity_;
  const bool localise_only_;
  // The last member: it uses the others.
  MinuteLog log_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_ROBOT_MINUTES_H_
