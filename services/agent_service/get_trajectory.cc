#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "services/agent_service/agent_service.h"
#include "services/convert/geometry.h"
#include "services/server/unary.h"

namespace corbslam {
namespace {

constexpr int kPosesPerMessage = 1000;

}  // namespace

grpc::ServerWriteReactor<v1::GetAgentTrajectoryResponse>* AgentService::GetTrajectory(
    grpc::CallbackServerContext*, const v1::GetAgentTrajectoryRequest* request) {
  using Reactor = StreamReactor<v1::GetAgentTrajectoryResponse>;
  const int64_t from_ns = request->from_timestamp_ns();
  return Reactor::Start(pool_, nullptr, [this, from_ns]() -> absl::StatusOr<Reactor::Next> {
    auto poses = std::make_shared<const std::vector<TrajectoryPose>>(agent_.LocalTrajectory());
    return [poses, from_ns, at = size_t{0}](v1::GetAgentTrajectoryResponse& response) mutable {
      for (; at < poses->size() && response.poses_size() < kPosesPerMessage; ++at) {
        const TrajectoryPose& pose = (*poses)[at];
        if (pose.timestamp_ns < from_ns) continue;
        v1::TrajectoryPose* proto = response.add_poses();
        proto->set_timestamp_ns(pose.timestamp_ns);
        ToProto(pose.local_from_camera, proto->mutable_frame_from_camera());
        proto->set_local_map(ToString(pose.local_map));
      }
      return response.poses_size() > 0;
    };
  });
}

}  // namespace corbslam
