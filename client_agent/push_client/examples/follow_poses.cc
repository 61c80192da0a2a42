// Follows a robot's poses, and where a map store is named asks how many keyframes its map has:
//   follow_poses ROBOT_HOST:PORT POSES [STORE_HOST:PORT MISSION]
// Without TLS, for robots and stores that run with --insecure; grpc::SslCredentials takes its
// place.
#include <corbslam/v1/agent_service.grpc.pb.h>
#include <corbslam/v1/map_store_service.grpc.pb.h>
#include <grpcpp/grpcpp.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace v1 = corbslam::v1;

namespace {

std::shared_ptr<grpc::Channel> Connect(const std::string& address) {
  return grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
}

// Prints so many poses. Returns whether they came.
bool FollowPoses(const std::string& robot, int poses) {
  const auto agent = v1::Agent::NewStub(Connect(robot));
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  const auto stream = agent->WatchPose(&context, v1::WatchPoseRequest());
  v1::WatchPoseResponse pose;
  for (; poses > 0 && stream->Read(&pose); --poses) {
    std::printf("%lld %s", static_cast<long long>(pose.timestamp_ns()),
                v1::TrackingState_Name(pose.state()).c_str());
    for (const double metres : pose.local_from_camera().translation()) std::printf(" %.3f", metres);
    std::printf("\n");
  }
  context.TryCancel();
  stream->Finish();
  return poses == 0;
}

// Prints how many keyframes the first answer holds: all that there are.
bool AskMap(const std::string& store, const std::string& mission) {
  const auto map_store = v1::MapStore::NewStub(Connect(store));
  grpc::ClientContext context;
  v1::WatchMapRequest request;
  request.set_mission("missions/" + mission);
  const auto stream = map_store->WatchMap(&context, request);
  v1::WatchMapResponse news;
  int keyframes = 0;
  do {
    if (!stream->Read(&news)) return false;
    for (const auto& island : news.islands()) keyframes += island.keyframes_size();
  } while (news.continues());
  std::printf("the map has %d keyframes\n", keyframes);
  context.TryCancel();
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 && argc != 5) {
    std::fprintf(stderr, "follow_poses ROBOT_HOST:PORT POSES [STORE_HOST:PORT MISSION]\n");
    return 2;
  }
  if (!FollowPoses(argv[1], std::atoi(argv[2]))) return 1;
  return argc == 3 || AskMap(argv[3], argv[4]) ? 0 : 1;
}
