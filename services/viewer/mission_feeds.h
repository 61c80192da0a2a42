// Keeps the feeds of the missions that somebody looks at.
#ifndef CORBSLAM_SERVICES_VIEWER_MISSION_FEEDS_H_
#define CORBSLAM_SERVICES_VIEWER_MISSION_FEEDS_H_

#include <grpcpp/channel.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "services/viewer/mission_feed.h"
#include "services/viewer/mission_upstream.h"

namespace corbslam::services {

struct MissionFeedsOptions {
  MissionFeedOptions feed;
  UpstreamOptions upstream;
  // Missions that are followed at once.
  size_t max_missions = 20;
  // A mission that nobody has looked at for so long is followed no more.
  absl::Duration linger = absl::Seconds(30);
};

// Follows a mission once, however many look at it. Thread-safe.
class MissionFeeds {
 public:
  // Robots that are asked how they are doing, by mission.
  using Robots = std::map<std::string, std::vector<AskedRobot>, std::less<>>;

  MissionFeeds(std::shared_ptr<StoreRoutes> routes, Robots robots,
               const MissionFeedsOptions& options = {});
  ~MissionFeeds();
  MissionFeeds(const MissionFeeds&) = delete;
  MissionFeeds& operator=(const MissionFeeds&) = delete;

  // Returns the mission's feed, which is followed as long as somebody holds it, and a while longer.
  // RESOURCE_EXHAUSTED: too many missions are looked at.
  absl::StatusOr<std::shared_ptr<MissionFeed>> Follow(const std::string& mission);
  size_t missions() const;

 private:
  struct Followed {
    explicit Followed(const MissionFeedOptions& options) : feed(options) {}

    MissionFeed feed;
    std::unique_ptr<MissionUpstream> upstream;
    absl::Time last_held = absl::InfinitePast();
  };

  // Gives up what nobody holds any more.
  void Sweep();
  // Takes one that nobody holds out, the one that has been left the longest; null: there is none.
  std::shared_ptr<Followed> TakeIdle(absl::Time held_before) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::shared_ptr<StoreRoutes> routes_;
  const Robots robots_;
  const MissionFeedsOptions options_;
  mutable absl::Mutex mutex_;
  std::map<std::string, std::shared_ptr<Followed>> followed_ ABSL_GUARDED_BY(mutex_);
  absl::Notification stop_;
  std::thread sweeper_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_MISSION_FEEDS_H_
