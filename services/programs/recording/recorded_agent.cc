#include "services/programs/recording/recorded_agent.h"

#include "services/programs/recording/frame_recorder.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::TrackingResult;
using client_agent::TrajectoryPose;

namespace {

class RecordedAgent : public Agent {
 public:
  RecordedAgent(Agent* agent, FrameRecorder* recorder) : agent_(*agent), recorder_(*recorder) {}

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override {
    recorder_.OnFrame(images);
    return agent_.Track(images);
  }
  void BeginLocalMap() override {
    recorder_.OnNewLocalMap();
    agent_.BeginLocalMap();
  }
  void Step() override { agent_.Step(); }
  absl::Status Finish(absl::Duration timeout) override { return agent_.Finish(timeout); }
  AgentStatus GetStatus() const override { return agent_.GetStatus(); }
  std::optional<Similarity3d> GlobalFromLocal() const override { return agent_.GlobalFromLocal(); }
  AgentTimings GetTimings() const override { return agent_.GetTimings(); }
  std::vector<TrajectoryPose> LocalTrajectory() const override { return agent_.LocalTrajectory(); }
  Map CopyMap() const override { return agent_.CopyMap(); }

 private:
  Agent& agent_;
  FrameRecorder& recorder_;
};

}  // namespace

std::unique_ptr<Agent> MakeRecordedAgent(Agent* agent, FrameRecorder* recorder) {
  return std::make_unique<RecordedAgent>(agent, recorder);
}

}  // namespace corbslam::services
