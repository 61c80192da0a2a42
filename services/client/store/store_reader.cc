#include "services/client/store/store_reader.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/store/call_status.h"
#include "services/convert/columns.h"
#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// How often a store is asked whether it is idle; it has no call that waits for that.
constexpr absl::Duration kAskAgain = absl::Milliseconds(100);

// Lets the call wait for a store that may be starting.
void WaitForAnswer(grpc::ClientContext& context) {
  SetDeadline(context);
  context.set_wait_for_ready(true);
}

using Agents = std::map<LocalMapId, std::string>;

// Returns "" where the local map's agent is not known.
std::string AgentOf(LocalMapId local_map, const Agents& agents) {
  const auto agent = agents.find(local_map);
  return agent == agents.end() ? "" : agent->second;
}

// Adds the keyframes and points of an island in the global frame.
absl::Status AddIsland(const v1::WatchMapResponse::Island& island, const SlotReader& slots,
                       const Agents& agents, ServedMap& map) {
  for (const v1::WatchMapResponse::IslandKeyframe& proto : island.keyframes()) {
    ServedMap::Keyframe& keyframe = map.keyframes.emplace_back();
    ASSIGN_OR_RETURN(keyframe.id, slots.Keyframe(proto.id()));
    if (proto.parent().slot() != 0) {
      ASSIGN_OR_RETURN(keyframe.parent, slots.Keyframe(proto.parent()));
    }
    ASSIGN_OR_RETURN(const Rigid3d camera_from_island, FromProto(proto.camera_from_island()));
    keyframe.global_from_camera = camera_from_island.Inverse();
    keyframe.agent = AgentOf(keyframe.id.local_map, agents);
  }
  ASSIGN_OR_RETURN(const std::vector<LightMapPoint> points,
                   ReadLightPoints(island.points(), slots));
  for (const LightMapPoint& point : points) {
    map.points.push_back(point.position_in_local);
    map.point_agents.push_back(AgentOf(point.id.local_map, agents));
  }
  return absl::OkStatus();
}

// Counts the keyframes and points of an island of its own. Its first message tells that it is one.
absl::Status CountElsewhere(const v1::WatchMapResponse::Island& island, const SlotReader& slots,
                            const Agents& agents, ServedMap::Elsewhere& elsewhere) {
  if (island.anew()) ++elsewhere.islands;
  for (const v1::WatchMapResponse::IslandKeyframe& proto : island.keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(proto.id()));
    ++elsewhere.keyframes[AgentOf(id.local_map, agents)];
  }
  ASSIGN_OR_RETURN(const std::vector<LightMapPoint> points,
                   ReadLightPoints(island.points(), slots));
  for (const LightMapPoint& point : points) ++elsewhere.points[AgentOf(point.id.local_map, agents)];
  return absl::OkStatus();
}

absl::Status AddResponse(const v1::WatchMapResponse& response, ServedMap& map) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(response.local_maps()));
  Agents agents;
  for (int i = 0; i < std::min(response.local_maps_size(), response.local_map_agents_size()); ++i) {
    agents[LocalMapId{response.local_maps(i)}] = LastSegment(response.local_map_agents(i));
  }
  for (const v1::WatchMapResponse::Island& island : response.islands()) {
    RETURN_IF_ERROR(island.in_global_frame()
                        ? AddIsland(island, slots, agents, map)
                        : CountElsewhere(island, slots, agents, map.elsewhere));
  }
  return absl::OkStatus();
}

}  // namespace

StoreReader::StoreReader(std::shared_ptr<grpc::Channel> channel, std::string mission)
    : channel_(std::move(channel)),
      mission_(std::move(mission)),
      stub_(v1::MapStore::NewStub(channel_)) {}

absl::StatusOr<v1::GetStatisticsResponse> StoreReader::Statistics() {
  grpc::ClientContext context;
  WaitForAnswer(context);
  v1::GetStatisticsRequest request;
  request.set_mission(MissionName(mission_));
  v1::GetStatisticsResponse response;
  RETURN_IF_ERROR(ToStatus(stub_->GetStatistics(&context, request, &response), "GetStatistics"));
  return response;
}

absl::Status StoreReader::WaitUntilFused(absl::Duration timeout) {
  const absl::Time deadline = absl::Now() + timeout;
  while (true) {
    ASSIGN_OR_RETURN(const v1::GetStatisticsResponse response, Statistics());
    if (response.mission().fusion_idle()) return absl::OkStatus();
    if (absl::Now() > deadline) {
      return absl::DeadlineExceededError(
          absl::StrCat("fusion is not idle after ", absl::FormatDuration(timeout)));
    }
    absl::SleepFor(kAskAgain);
  }
}

absl::StatusOr<std::map<std::string, v1::MissionAgent>> StoreReader::ListAgents() {
  v1::ListAgentsRequest request;
  request.set_parent(MissionName(mission_));
  std::map<std::string, v1::MissionAgent> agents;
  do {
    grpc::ClientContext context;
    WaitForAnswer(context);
    v1::ListAgentsResponse response;
    const grpc::Status status = stub_->ListAgents(&context, request, &response);
    if (status.error_code() == grpc::StatusCode::NOT_FOUND) return agents;
    RETURN_IF_ERROR(ToStatus(status, "ListAgents"));
    for (const v1::MissionAgent& agent : response.agents()) {
      agents[LastSegment(agent.name())] = agent;
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return agents;
}

absl::StatusOr<std::vector<v1::LocalMap>> StoreReader::ListLocalMaps() {
  v1::ListLocalMapsRequest request;
  request.set_parent(MissionName(mission_));
  std::vector<v1::LocalMap> local_maps;
  do {
    grpc::ClientContext context;
    WaitForAnswer(context);
    v1::ListLocalMapsResponse response;
    const grpc::Status status = stub_->ListLocalMaps(&context, request, &response);
    if (status.error_code() == grpc::StatusCode::NOT_FOUND) return local_maps;
    RETURN_IF_ERROR(ToStatus(status, "ListLocalMaps"));
    local_maps.insert(local_maps.end(), response.local_maps().begin(), response.local_maps().end());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return local_maps;
}

absl::StatusOr<std::map<std::string, uint64_t>> StoreReader::CountReportedFrames() {
  ASSIGN_OR_RETURN(const std::vector<v1::LocalMap> local_maps, ListLocalMaps());
  std::map<std::string, uint64_t> frames;
  for (const v1::LocalMap& local_map : local_maps) {
    frames[LastSegment(local_map.agent())] += local_map.tracked_frames() + local_map.lost_frames();
  }
  return frames;
}

absl::StatusOr<ServedTrajectory> StoreReader::ReadTrajectory(const std::string& agent,
                                                             v1::TrajectoryFrame frame,
                                                             PosesOf poses_of, Reach reach,
                                                             UnposedFrames* unposed) {
  grpc::ClientContext context;
  SetStreamDeadline(context);
  v1::GetTrajectoryRequest request;
  request.set_name(AgentName(mission_, agent));
  request.set_frame(frame);
  request.set_poses_of(ToProto(poses_of));
  request.set_all_islands(reach == Reach::kAllIslands);
  ServedTrajectory trajectory;
  const auto reader = stub_->GetTrajectory(&context, request);
  v1::GetTrajectoryResponse response;
  UnposedFrames without;
  bool is_wanted = true;
  while (reader->Read(&response)) {
    is_wanted = is_wanted && response.poses_of() == request.poses_of();
    without = {response.frames_lost(), response.frames_left_out(),
               response.localised_frames_dropped()};
    for (const v1::TrajectoryPose& pose : response.poses()) {
      ASSIGN_OR_RETURN(const Rigid3d frame_from_camera, FromProto(pose.frame_from_camera()));
      trajectory.push_back({pose.timestamp_ns(), frame_from_camera,
                            pose.run() == 0 ? pose.local_map() : NameOfRun(pose.run()),
                            pose.island(), pose.after_gap()});
    }
  }
  RETURN_IF_ERROR(ToStatus(reader->Finish(), absl::StrCat("GetTrajectory of ", agent)));
  if (unposed != nullptr) *unposed = without;
  if (without.dropped > 0) {
    LOG(WARNING) << "the trajectory of " << agent << " is coarser than it was: of a robot that "
                 << "only localised the map store has dropped " << without.dropped << " frames";
  }
  if (!is_wanted && poses_of != PosesOf::kRectifiedCamera) {
    return absl::FailedPreconditionError(
        absl::StrCat("the map store is older than this program and gives poses of ",
                     Describe(PosesOf::kRectifiedCamera), " only, not of ", Describe(poses_of)));
  }
  return trajectory;
}

absl::StatusOr<ServedMap> StoreReader::ReadGlobalMap() {
  ServedMap map;
  RETURN_IF_ERROR(ReadPresent(
      /*with_points=*/true,
      [&map](const v1::WatchMapResponse& response) { return AddResponse(response, map); }));
  return map;
}

}  // namespace corbslam::services
