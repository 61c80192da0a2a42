// Serves the robot's own service: Agent of proto/corbslam/v1/agent_service.proto.
#ifndef CORBSLAM_SERVICES_AGENT_SERVICE_AGENT_SERVICE_H_
#define CORBSLAM_SERVICES_AGENT_SERVICE_AGENT_SERVICE_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/agent/activity_watch.h"
#include "client_agent/agent/agent.h"
#include "client_agent/agent/agent_events.h"
#include "client_agent/agent/agent_orders.h"
#include "corbslam/v1/agent_service.grpc.pb.h"
#include "services/agent_service/pose_board.h"
#include "services/server/task_pool.h"
#include "slam/camera/recorded_camera.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

struct AgentServiceOptions {
  // Empty without a map store.
  std::string mission;
  std::string agent;
  // The camera that recorded the agent's pictures; nullopt: the agent's own camera did.
  std::optional<RecordedCamera> recorded_camera = std::nullopt;
  // Returns OK while a session with the store stands, else an error that says why there is none;
  // null: not known.
  std::function<absl::Status()> session = nullptr;
  // Where orders go; null: PauseMapping and the others are UNIMPLEMENTED.
  std::shared_ptr<client_agent::AgentOrders> orders = nullptr;
  // What WatchEvents tells, and where frames are noted; null: WatchEvents is UNIMPLEMENTED.
  std::shared_ptr<client_agent::AgentEvents> events = nullptr;
  // Where frames are noted for what the robot is doing; null: its tracking alone says that.
  std::shared_ptr<const client_agent::ActivityWatch> activity = nullptr;
  bool localise_only = false;  // As AgentOptions::localise_only.
  // What the frames' times count.
  v1::AgentClock clock = v1::AGENT_CLOCK_RECORDED;
};

// Answers calls about one agent. `agent` and `uplink` (null: no map store) are not owned and must
// outlive it; the server must be shut down before it is destroyed. Thread-safe.
class AgentService : public v1::Agent::CallbackService {
 public:
  AgentService(const client_agent::Agent* agent, const Uplink* uplink,
               const AgentServiceOptions& options)
      : agent_(*agent), uplink_(uplink), options_(options), pool_(1) {}

  // Tells watchers of a frame; `dropped` counts the frames so far that came too fast, and `came` is
  // when this one did.
  void OnFrame(const client_agent::TrackingResult& result, uint64_t dropped,
               PoseBoard::Moment came = std::chrono::steady_clock::now());
  // Tells them that no frame comes any more, which ends their streams.
  void OnEnd();

  grpc::ServerWriteReactor<v1::WatchPoseResponse>* WatchPose(
      grpc::CallbackServerContext* context, const v1::WatchPoseRequest* request) override;
  grpc::ServerWriteReactor<v1::AgentEvent>* WatchEvents(
      grpc::CallbackServerContext* context, const v1::WatchAgentEventsRequest* request) override;
  grpc::ServerWriteReactor<v1::WatchAgentMapResponse>* WatchMap(
      grpc::CallbackServerContext* context, const v1::WatchAgentMapRequest* request) override;
  grpc::ServerUnaryReactor* GetStatus(grpc::CallbackServerContext* context,
                                      const v1::GetStatusRequest* request,
                                      v1::AgentStatus* response) override;
  grpc::ServerWriteReactor<v1::GetAgentTrajectoryResponse>* GetTrajectory(
      grpc::CallbackServerContext* context, const v1::GetAgentTrajectoryRequest* request) override;
  grpc::ServerUnaryReactor* PauseMapping(grpc::CallbackServerContext* context,
                                         const v1::PauseMappingRequest* request,
                                         v1::PauseMappingResponse* response) override;
  grpc::ServerUnaryReactor* ResumeMapping(grpc::CallbackServerContext* context,
                                          const v1::ResumeMappingRequest* request,
                                          v1::ResumeMappingResponse* response) override;
  grpc::ServerUnaryReactor* OpenNewMap(grpc::CallbackServerContext* context,
                                       const v1::OpenNewMapRequest* request,
                                       v1::OpenNewMapResponse* response) override;
  grpc::ServerUnaryReactor* SetMask(grpc::CallbackServerContext* context,
                                    const v1::SetMaskRequest* request,
                                    v1::SetMaskResponse* response) override;

 private:
  using Order = std::function<absl::Status(client_agent::AgentOrders&)>;
  grpc::ServerUnaryReactor* Give(grpc::CallbackServerContext* context, Order order);

  const client_agent::Agent& agent_;
  const Uplink* const uplink_;
  const AgentServiceOptions options_;
  PoseBoard poses_;
  TaskPool pool_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_AGENT_SERVICE_AGENT_SERVICE_H_
