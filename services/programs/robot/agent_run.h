// Plays a recorded sequence into an agent.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_RUN_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_RUN_H_

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/synchronization/notification.h"
#include "client_agent/agent/agent.h"
#include "client_agent/source/image_source.h"
#include "services/programs/robot/robot_report.h"

namespace corbslam {

enum class Pace {
  kSensor,  // In the sequence's own time; frames that come too fast are dropped.
  kMax,     // As fast as the agent takes them.
};

struct PlayedFrames {
  uint64_t played = 0;
  uint64_t dropped = 0;
  uint64_t left_out = 0;  // They could not be read.
};

// Until the last frame, or until `stop`. `on_frame` hears each result and the frames dropped so
// far. A frame that can't be read is left out, counted and logged; the agent begins a new local map
// where the source's time jumps back.
absl::Status PlaySource(
    ImageSource& source, Agent& agent, Pace pace, const absl::Notification& stop,
    PlayedFrames& frames,
    const std::function<void(const TrackingResult&, uint64_t dropped)>& on_frame);

// What looked wrong over a whole run: `at_start`, then what the agent's sensor gave, frames that
// were left out, and that nothing was tracked.
SourceFindings CollectWarnings(const SourceFindings& at_start, const Agent& agent,
                               const ImageSource& source, const PlayedFrames& played);

// What the run adds to the report of the agent that played: its frames and the time they took, what
// looked wrong and what this process used.
void AddRun(const ImageSource& source, const PlayedFrames& played, const SourceFindings& warnings,
            RobotReport& report);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_RUN_H_
