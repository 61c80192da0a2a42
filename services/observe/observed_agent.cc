#include "services/observe/observed_agent.h"

#include <utility>

#include "absl/time/clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::TrackingResult;
using client_agent::TrajectoryPose;

namespace {

class ObservedAgent : public Agent {
 public:
  ObservedAgent(Agent* agent, std::vector<FrameObserver*> observers)
      : agent_(*agent), observers_(std::move(observers)) {}

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override {
    for (FrameObserver* observer : observers_) observer->OnFrame(images.timestamp_ns);
    const absl::Time start = absl::Now();
    ASSIGN_OR_RETURN(const TrackingResult result, agent_.Track(images));
    for (FrameObserver* observer : observers_) observer->OnTracked(result, absl::Now() - start);
    return result;
  }

  void BeginLocalMap() override { agent_.BeginLocalMap(); }
  void Step() override { agent_.Step(); }
  absl::Status Finish(absl::Duration timeout) override { return agent_.Finish(timeout); }
  AgentStatus GetStatus() const override { return agent_.GetStatus(); }
  std::optional<Similarity3d> GlobalFromLocal() const override { return agent_.GlobalFromLocal(); }
  AgentTimings GetTimings() const override { return agent_.GetTimings(); }
  std::vector<TrajectoryPose> LocalTrajectory() const override { return agent_.LocalTrajectory(); }
  Map CopyMap() const override { return agent_.CopyMap(); }

 private:
  Agent& agent_;
  const std::vector<FrameObserver*> observers_;
};

}  // namespace

std::unique_ptr<Agent> MakeObservedAgent(Agent* agent, std::vector<FrameObserver*> observers) {
  return std::make_unique<ObservedAgent>(agent, std::move(observers));
}

}  // namespace corbslam::services
