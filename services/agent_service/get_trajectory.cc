#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "services/agent_service/agent_service.h"
#include "services/convert/geometry.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::ToString;
using client_agent::TrajectoryPose;

namespace {

constexpr int kPosesPerMessage = 1000;

}  // namespace

grpc::ServerWriteReactor<v1::GetAgentTrajectoryResponse>* AgentService::GetTrajectory(
    grpc::CallbackServerContext*, const v1::GetAgentTrajectoryRequest* request) {
  using Reactor = StreamReactor<v1::GetAgentTrajectoryResponse>;
  return Reactor::Start(
      pool_, nullptr, [this, request = *request]() -> absl::StatusOr<Reactor::Next> {
        ASSIGN_OR_RETURN(const PosesOf poses_of, FromProto(request.poses_of()));
        ASSIGN_OR_RETURN(const auto camera_from_wanted,
                         CameraFromWanted(options_.recorded_camera, poses_of));
        auto poses = std::make_shared<const std::vector<TrajectoryPose>>(agent_.LocalTrajectory());
        return [poses, from_ns = request.from_timestamp_ns(), poses_of, camera_from_wanted,
                at = size_t{0}](v1::GetAgentTrajectoryResponse& response) mutable {
          response.set_poses_of(ToProto(poses_of));
          for (; at < poses->size() && response.poses_size() < kPosesPerMessage; ++at) {
            const TrajectoryPose& pose = (*poses)[at];
            if (pose.timestamp_ns < from_ns) continue;
            v1::TrajectoryPose* proto = response.add_poses();
            proto->set_timestamp_ns(pose.timestamp_ns);
            ToProto(camera_from_wanted ? pose.local_from_camera * *camera_from_wanted
                                       : pose.local_from_camera,
                    proto->mutable_frame_from_camera());
            proto->set_local_map(ToString(pose.local_map));
          }
          return response.poses_size() > 0;
        };
      });
}

}  // namespace corbslam::services
