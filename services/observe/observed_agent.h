// Makes an agent that tells others of each frame.
#ifndef CORBSLAM_SERVICES_OBSERVE_OBSERVED_AGENT_H_
#define CORBSLAM_SERVICES_OBSERVE_OBSERVED_AGENT_H_

#include <memory>
#include <vector>

#include "absl/time/time.h"
#include "client_agent/agent/agent.h"

namespace corbslam::services {

// Hears of frames, on the thread that tracks; its functions must return soon.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  virtual void OnTracked(const client_agent::TrackingResult& result, absl::Duration took) = 0;
};

// Makes an agent whose thread contract and effect are those of `agent`. Neither it nor `observers`
// is owned; both must outlive the result.
std::unique_ptr<client_agent::Agent> MakeObservedAgent(client_agent::Agent* agent,
                                                       std::vector<FrameObserver*> observers);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_OBSERVED_AGENT_H_
