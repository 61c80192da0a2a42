// Follows one mission of a map store for a feed, and comes back after every failure.
#ifndef CORBSLAM_SERVICES_VIEWER_MISSION_UPSTREAM_H_
#define CORBSLAM_SERVICES_VIEWER_MISSION_UPSTREAM_H_

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "corbslam/v1/agent_service.grpc.pb.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/remote/store_route.h"
#include "services/viewer/mission_feed.h"

namespace corbslam::services {

// A robot that is asked how it is doing.
struct AskedRobot {
  std::string agent;  // By its own name.
  std::shared_ptr<grpc::Channel> channel;
};

struct UpstreamOptions {
  absl::Duration pulse_interval = absl::Seconds(1);
  // Pauses after a failure grow from the first to the second.
  absl::Duration first_pause = absl::Milliseconds(250);
  absl::Duration longest_pause = absl::Seconds(5);
};

// Has three threads: for the map, for events, and for what is asked again and again. They end with
// it. A mission that is not there is waited for, and one that is at another store followed there.
class MissionUpstream {
 public:
  // `feed` is not owned and must outlive it.
  MissionUpstream(std::string mission, std::shared_ptr<StoreRoute> route,
                  const std::vector<AskedRobot>& robots, MissionFeed* feed,
                  const UpstreamOptions& options = {});
  ~MissionUpstream();
  MissionUpstream(const MissionUpstream&) = delete;
  MissionUpstream& operator=(const MissionUpstream&) = delete;

 private:
  class Call;
  class RobotQuestion;
  struct Robot {
    std::string agent;
    std::unique_ptr<v1::Agent::Stub> stub;
  };

  // Calls `attempt` again and again, with pauses that begin anew once an attempt has got something.
  template <typename Attempt>
  void Repeat(Attempt attempt);
  absl::Status FollowMap(v1::MapStore::Stub& store, bool& got_something);
  absl::Status FollowEvents(v1::MapStore::Stub& store, bool& got_something);
  void TakePulses();
  v1::MissionPulse TakePulse();
  absl::Status AskStore(v1::MapStore::Stub& store, v1::MissionPulse& pulse);

  const std::string mission_;
  const UpstreamOptions options_;
  MissionFeed& feed_;
  const std::shared_ptr<StoreRoute> route_;
  std::vector<Robot> robots_;

  absl::Notification stop_;
  absl::Mutex mutex_;
  std::set<grpc::ClientContext*> calls_ ABSL_GUARDED_BY(mutex_);
  absl::Status map_status_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> threads_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_MISSION_UPSTREAM_H_
