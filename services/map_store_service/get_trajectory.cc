#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "services/convert/geometry.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::AgentTrajectory;
using map_store::MissionInfo;
using map_store::TrajectoryFrame;

namespace {

constexpr size_t kPosesPerMessage = 1000;

// Walks over all poses of all agents.
struct Walk {
  std::string mission;
  bool global = false;
  v1::PosesOf poses_of = v1::POSES_OF_UNSPECIFIED;
  uint64_t revision = 0;
  std::vector<AgentTrajectory> trajectories;
  size_t agent = 0;
  size_t pose = 0;
  bool has_begun = false;

  bool AtEnd() {
    while (agent < trajectories.size() && pose == trajectories[agent].poses.size()) {
      ++agent;
      pose = 0;
    }
    return agent == trajectories.size();
  }
};

template <typename Pose>
void PoseToProto(const Walk& walk, const std::string& agent, const Pose& pose,
                 v1::TrajectoryPose* proto) {
  proto->set_agent(AgentName(walk.mission, agent));
  proto->set_timestamp_ns(pose.timestamp_ns);
  ToProto(pose.frame_from_camera, proto->mutable_frame_from_camera());
  if (pose.run == 0) proto->set_local_map(LocalMapName(walk.mission, pose.local_map));
  if (walk.global) proto->set_island(LocalMapName(walk.mission, pose.island));
  proto->set_after_gap(pose.after_gap);
  proto->set_run(pose.run);
}

void CountsToProto(const Walk& walk, v1::GetTrajectoryResponse& response) {
  uint64_t dropped = 0;
  uint64_t lost = 0;
  uint64_t left_out = 0;
  for (const AgentTrajectory& trajectory : walk.trajectories) {
    dropped += trajectory.dropped;
    lost += trajectory.lost;
    left_out += trajectory.left_out;
  }
  response.set_localised_frames_dropped(dropped);
  response.set_frames_lost(lost);
  response.set_frames_left_out(left_out);
}

bool FillNext(Walk& walk, v1::GetTrajectoryResponse& response) {
  // Without any pose one message still says why.
  if (walk.AtEnd() && walk.has_begun) return false;
  walk.has_begun = true;
  response.set_revision(walk.revision);
  response.set_poses_of(walk.poses_of);
  CountsToProto(walk, response);
  while (!walk.AtEnd() && static_cast<size_t>(response.poses_size()) < kPosesPerMessage) {
    const AgentTrajectory& trajectory = walk.trajectories[walk.agent];
    PoseToProto(walk, trajectory.agent, trajectory.poses[walk.pose++], response.add_poses());
  }
  return true;
}

absl::StatusOr<TrajectoryFrame> ReadFrame(v1::TrajectoryFrame frame) {
  if (frame == v1::TRAJECTORY_FRAME_LOCAL) return TrajectoryFrame::kLocal;
  if (frame == v1::TRAJECTORY_FRAME_GLOBAL) return TrajectoryFrame::kGlobal;
  return absl::InvalidArgumentError(
      absl::StrCat("frame is ", static_cast<int>(frame), ", must be 1 (local) or 2 (global)"));
}

}  // namespace

grpc::ServerWriteReactor<v1::GetTrajectoryResponse>* MapStoreService::GetTrajectory(
    grpc::CallbackServerContext* context, const v1::GetTrajectoryRequest* request) {
  using Reactor = StreamReactor<v1::GetTrajectoryResponse>;
  return Reactor::Start(
      pool_, limits_.Enter(context->peer()),
      [this, request = *request]() -> absl::StatusOr<Reactor::Next> {
        ASSIGN_OR_RETURN(const AgentPath path, ParseAgentName(request.name(), /*may_be_all=*/true));
        ASSIGN_OR_RETURN(const TrajectoryFrame frame, ReadFrame(request.frame()));
        ASSIGN_OR_RETURN(const PosesOf poses_of, FromProto(request.poses_of()));
        auto walk = std::make_shared<Walk>();
        walk->poses_of = ToProto(poses_of);
        walk->mission = path.mission;
        walk->global = frame == TrajectoryFrame::kGlobal;
        ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(path.mission));
        walk->revision = info.revision;
        ASSIGN_OR_RETURN(walk->trajectories, store_.GetTrajectory(path.mission, path.agent, frame,
                                                                  request.all_islands(), poses_of));
        return [walk](v1::GetTrajectoryResponse& response) { return FillNext(*walk, response); };
      });
}

}  // namespace corbslam::services
