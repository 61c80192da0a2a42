#include "services/programs/recording/recorded_agent.h"

#include "client_agent/agent/forwarding_agent.h"
#include "services/programs/recording/frame_recorder.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::ForwardingAgent;
using client_agent::TrackingResult;

namespace {

class RecordedAgent : public ForwardingAgent {
 public:
  RecordedAgent(Agent* agent, FrameRecorder* recorder)
      : ForwardingAgent(agent), recorder_(*recorder) {}

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override {
    recorder_.OnFrame(images);
    return ForwardingAgent::Track(images);
  }
  void BeginLocalMap() override {
    recorder_.OnNewLocalMap();
    ForwardingAgent::BeginLocalMap();
  }

 private:
  FrameRecorder& recorder_;
};

}  // namespace

std::unique_ptr<Agent> MakeRecordedAgent(Agent* agent, FrameRecorder* recorder) {
  return std::make_unique<RecordedAgent>(agent, recorder);
}

}  // namespace corbslam::services
