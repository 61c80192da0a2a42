// Passes everything on to another agent: what those derive from that add to some of it.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_FORWARDING_AGENT_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_FORWARDING_AGENT_H_

#include <optional>
#include <vector>

#include "client_agent/agent/agent.h"

namespace corbslam::client_agent {

class ForwardingAgent : public Agent {
 public:
  // `agent` is not owned and must outlive it.
  explicit ForwardingAgent(Agent* agent) : agent_(*agent) {}

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override {
    return agent_.Track(images);
  }
  absl::Status UsePause() override { return agent_.UsePause(); }
  void BeginLocalMap() override { agent_.BeginLocalMap(); }
  void Step() override { agent_.Step(); }
  absl::Status Finish(absl::Duration timeout) override { return agent_.Finish(timeout); }
  AgentStatus GetStatus() const override { return agent_.GetStatus(); }
  AgentTimings GetTimings() const override { return agent_.GetTimings(); }
  std::vector<TrajectoryPose> LocalTrajectory() const override { return agent_.LocalTrajectory(); }
  Map CopyMap() const override { return agent_.CopyMap(); }
  std::optional<NearMap> GetNearMap(const NearMapLimits& limits) const override {
    return agent_.GetNearMap(limits);
  }

 private:
  Agent& agent_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_FORWARDING_AGENT_H_
