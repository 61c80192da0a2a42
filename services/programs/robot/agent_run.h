// Plays a stream of frames into an agent.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_RUN_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_RUN_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/synchronization/notification.h"
#include "client_agent/agent/agent.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_description.h"
#include "services/programs/robot/frame_rate_limit.h"
#include "services/programs/robot/paced_stream.h"
#include "services/programs/robot/relocalisation_count.h"
#include "services/programs/robot/robot_report.h"
#include "slam/util/bounded_sample.h"

namespace corbslam::services {

struct PlayedFrames {
  uint64_t played = 0;
  uint64_t dropped = 0;
  uint64_t left_out = 0;     // Frames that could not be read.
  bool stopped = false;      // Somebody stopped it before the stream's end.
  BoundedSample latency_ms;  // From a camera's picture to its pose.
  SourcePace source_pace;    // Of a source that makes its frames, at Pace::kSensor.
  RelocalisationCount relocalised;
};

// What is known of a played frame beside its result.
struct FrameMoment {
  // When it came; a recording's frame comes when it is given to the agent.
  std::chrono::steady_clock::time_point came;
  uint64_t dropped = 0;  // Frames before it that came too fast.
};

// Plays until the last frame, or until `stop`. `on_frame` is called with each result, after the
// stream's own listener to poses. A frame that can't be read is
// left out, counted and logged (of a camera seldom, with counts); a source that is too slow for its
// own times is logged; the agent
// begins a new local map where the stream's time jumps back. A stream that fails ends with its
// status, after the frames that came before. Frames that `limit` does not take count as dropped.
absl::Status PlayStream(
    client_agent::FrameStream& stream, client_agent::Agent& agent, Pace pace,
    const absl::Notification& stop, PlayedFrames& frames,
    const std::function<void(const client_agent::TrackingResult&, const FrameMoment&)>& on_frame,
    FrameRateLimit* limit = nullptr);

// What the robot was told to do, for words about a run that tracked nothing.
struct RobotTask {
  bool localise_only = false;
  bool resume = false;
  std::string mission;
  // Only keyframes near where the robot is known to be are sent to it.
  bool shares_nearby = false;
  absl::Status session;  // Why no session stands with the store; OK: one does, or none is wanted.
};

// Returns what looked wrong over a whole run: `at_start`, then what the agent's sensor found,
// the stream in its frames, frames that were left out, and that nothing was tracked: not so where
// somebody stopped the robot before its first frame.
client_agent::SourceFindings CollectWarnings(const client_agent::SourceFindings& at_start,
                                             const client_agent::Agent& agent,
                                             const client_agent::FrameStream& stream,
                                             const PlayedFrames& played,
                                             const RobotTask& task = {});

// Adds to the report of the agent what the run knows: its frames and the time they took, what
// looked wrong and what this process used.
void AddRun(const client_agent::FrameStream& stream, const PlayedFrames& played,
            const client_agent::SourceFindings& warnings, RobotReport& report);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_RUN_H_
