#include "services/observe/observed_agent.h"

#include <utility>

#include "absl/time/clock.h"
#include "client_agent/agent/forwarding_agent.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::ForwardingAgent;
using client_agent::TrackingResult;

namespace {

class ObservedAgent : public ForwardingAgent {
 public:
  ObservedAgent(Agent* agent, std::vector<FrameObserver*> observers)
      : ForwardingAgent(agent), observers_(std::move(observers)) {}

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override {
    const absl::Time start = absl::Now();
    ASSIGN_OR_RETURN(const TrackingResult result, ForwardingAgent::Track(images));
    for (FrameObserver* observer : observers_) observer->OnTracked(result, absl::Now() - start);
    return result;
  }

 private:
  const std::vector<FrameObserver*> observers_;
};

}  // namespace

std::unique_ptr<Agent> MakeObservedAgent(Agent* agent, std::vector<FrameObserver*> observers) {
  return std::make_unique<ObservedAgent>(agent, std::move(observers));
}

}  // namespace corbslam::services
