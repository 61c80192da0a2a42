#include "services/viewer/mission_feeds.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kSweepInterval = absl::Seconds(1);

}  // namespace

MissionFeeds::MissionFeeds(std::shared_ptr<StoreRoutes> routes, Robots robots,
                           const MissionFeedsOptions& options)
    : routes_(std::move(routes)),
      robots_(std::move(robots)),
      options_(options),
      sweeper_(StartThread("feed sweeper", [this] {
        while (!stop_.WaitForNotificationWithTimeout(kSweepInterval)) Sweep();
      })) {}

MissionFeeds::~MissionFeeds() {
  stop_.Notify();
  sweeper_.join();
}

absl::StatusOr<std::shared_ptr<MissionFeed>> MissionFeeds::Follow(const std::string& mission) {
  // Its threads end behind the lock.
  std::shared_ptr<Followed> idle;
  absl::MutexLock lock(&mutex_);
  auto it = followed_.find(mission);
  if (it == followed_.end()) {
    if (followed_.size() >= options_.max_missions) {
      idle = TakeIdle(absl::InfiniteFuture());
      if (idle == nullptr) {
        return absl::ResourceExhaustedError(
            absl::StrCat("pages look at ", followed_.size(),
                         " missions already, which is the limit; try again later"));
      }
    }
    const auto robots = robots_.find(mission);
    auto followed = std::make_shared<Followed>(options_.feed);
    followed->upstream = std::make_unique<MissionUpstream>(
        mission, routes_->Of(mission),
        robots == robots_.end() ? std::vector<AskedRobot>() : robots->second, &followed->feed,
        options_.upstream);
    it = followed_.emplace(mission, std::move(followed)).first;
  }
  it->second->last_held = absl::Now();
  return std::shared_ptr<MissionFeed>(it->second, &it->second->feed);
}

std::shared_ptr<MissionFeeds::Followed> MissionFeeds::TakeIdle(absl::Time held_before) {
  auto oldest = followed_.end();
  for (auto it = followed_.begin(); it != followed_.end(); ++it) {
    if (it->second.use_count() > 1) {
      it->second->last_held = absl::Now();
    } else if (it->second->last_held < held_before &&
               (oldest == followed_.end() || it->second->last_held < oldest->second->last_held)) {
      oldest = it;
    }
  }
  if (oldest == followed_.end()) return nullptr;
  return std::move(followed_.extract(oldest).mapped());
}

void MissionFeeds::Sweep() {
  std::shared_ptr<Followed> idle;
  absl::MutexLock lock(&mutex_);
  idle = TakeIdle(absl::Now() - options_.linger);
}

size_t MissionFeeds::missions() const {
  absl::ReaderMutexLock lock(&mutex_);
  return followed_.size();
}

}  // namespace corbslam::services
