#include "services/client/remote/store_route.h"

#include <glog/logging.h>

#include "absl/strings/str_cat.h"
#include "services/client/remote/channel.h"
#include "services/runtime/address.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Returns whether the store did not answer at all, as far as its caller can tell.
bool IsNotReached(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status);
}

}  // namespace

ConnectToOther ConnectWith(std::shared_ptr<grpc::ChannelCredentials> credentials) {
  return [credentials = std::move(credentials)](
             const std::string& address) -> absl::StatusOr<std::shared_ptr<grpc::Channel>> {
    RETURN_IF_ERROR(ParseServerAddress(address).status());
    return MakeChannel(address, credentials);
  };
}

std::shared_ptr<grpc::Channel> StoreRoute::channel() const {
  absl::MutexLock lock(&mutex_);
  return at_other_ ? other_ : named_;
}

absl::Status StoreRoute::GoTo(const std::string& address) {
  if (connect_ == nullptr) return absl::FailedPreconditionError("nobody follows it here");
  {
    absl::MutexLock lock(&mutex_);
    if (other_ != nullptr && other_address_ == address) {
      at_other_ = true;
      return absl::OkStatus();
    }
  }
  ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> other, connect_(address));
  LOG(INFO) << "the mission is at the map store " << address << ": it is asked from now on";
  absl::MutexLock lock(&mutex_);
  other_ = std::move(other);
  other_address_ = address;
  at_other_ = true;
  return absl::OkStatus();
}

void StoreRoute::GoElsewhere(const std::shared_ptr<grpc::Channel>& asked) {
  absl::MutexLock lock(&mutex_);
  if (at_other_) {
    // Another thread's call has gone elsewhere already, unless this is where calls go now.
    at_other_ = asked != other_;
  } else {
    at_other_ = asked == named_ && other_ != nullptr;
  }
}

bool StoreRoute::Follow(const std::shared_ptr<grpc::Channel>& asked, absl::Status& status,
                        int& hops) {
  if (status.ok()) return false;
  const auto elsewhere = FindElsewhere(status);
  if (!elsewhere.has_value() || elsewhere->address.empty()) {
    if (IsNotReached(status)) GoElsewhere(asked);
    return false;
  }
  absl::Status gone;
  if (++hops > kMaxHops) {
    gone = absl::UnavailableError(absl::StrCat(kMaxHops, " stores sent on from one to the next"));
    GoElsewhere(asked);
  } else {
    gone = GoTo(elsewhere->address);
  }
  if (gone.ok()) return true;
  status = WithMessage(status, absl::StrCat(status.message(), "; ", elsewhere->address,
                                            " is not asked: ", gone.message()));
  return false;
}

std::shared_ptr<StoreRoute> StoreRoutes::Of(const std::string& mission) {
  absl::MutexLock lock(&mutex_);
  if (routes_.size() >= kMaxRoutes && routes_.count(mission) == 0) {
    std::erase_if(routes_, [](const auto& route) { return route.second.use_count() == 1; });
  }
  std::shared_ptr<StoreRoute>& route = routes_[mission];
  if (route == nullptr) route = std::make_shared<StoreRoute>(named_, connect_);
  return route;
}

}  // namespace corbslam::services
