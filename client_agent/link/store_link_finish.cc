// Implements the part of StoreLink that waits until everything is told, and says what is left.
#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "client_agent/link/store_link.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::Duration kMostForPictures = absl::Seconds(2);

}  // namespace

absl::Status StoreLink::Finish(absl::Duration timeout) {
  if (uplink_ == nullptr) return absl::OkStatus();
  // The thread may never come to it.
  SendReport();
  if (options_.localise_only) {
    localised_.ResetPatience();
    SendLocalised(/*all=*/true);
  }
  {
    absl::MutexLock lock(&mutex_);
    for (auto& recording : recordings_) recording->closing = true;
    if (!recordings_.empty()) {
      recordings_.back()->stays_open = options_.resumable && WritesAll();
    }
    wake_ = true;
  }
  if (!thread_.joinable()) Step();
  const absl::Time deadline = absl::Now() + timeout;
  absl::MutexLock lock(&mutex_);
  const auto finished = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return IsDone() || !refusal_.ok() || IsToldWithoutLink();
  };
  if (!mutex_.AwaitWithTimeout(absl::Condition(&finished), timeout)) {
    return absl::DeadlineExceededError(
        absl::StrCat("the map store has not acknowledged everything yet", DescribeWhatIsLeft(),
                     session_ == Session::kOpen || closed_.ok()
                         ? ""
                         : absl::StrCat(", and no session stands: ", closed_.ToString())));
  }
  if (!refusal_.ok()) return refusal_;
  if (!has_link_) return queue_.status().room;
  AwaitPictures(std::min(deadline - absl::Now(), kMostForPictures));
  return needs_new_local_map_ ? queue_.status().loss : absl::OkStatus();
}

void StoreLink::AwaitPictures(absl::Duration timeout) {
  if (!thread_.joinable()) return;
  const auto gone = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    // What waits in the transport counts: it would be cut off.
    return session_ != Session::kOpen || budget_.is_bounded() ||
           (!pictures_.HasReady() && uplink_->bytes_waiting() == 0);
  };
  mutex_.AwaitWithTimeout(absl::Condition(&gone), timeout);
}

std::string StoreLink::DescribeWhatIsLeft() const {
  const std::string budget = budget_.is_bounded()
                                 ? absl::StrCat("; held back by a budget of ",
                                                budget_.bytes_per_second(), " bytes a second")
                                 : "";
  if (options_.localise_only) {
    return absl::StrCat(" (", localised_.CountUnkept(), " frames of the trajectory", budget, ")");
  }
  if (budget.empty()) return "";
  return absl::StrCat(" (", queue_.status().batches, " batches", budget, ": ",
                      ToString(held_back_.status(options_.clock()).items), ")");
}

bool StoreLink::IsToldWithoutLink() const {
  if (has_link_) return false;
  const bool told = std::all_of(recordings_.begin(), recordings_.end(),
                                [](const auto& recording) { return recording->closed; });
  // A disk that is full is not waited for.
  return told && !queue_.status().room.ok();
}

bool StoreLink::IsDone() const {
  if (has_link_ ? !queue_.IsEmpty() : !queue_.IsOnDisk()) return false;
  if (localised_.CountUnkept() > 0) return false;
  return std::all_of(recordings_.begin(), recordings_.end(),
                     [](const auto& recording) { return recording->closed; });
}

bool StoreLink::IsFinishing() const {
  absl::MutexLock lock(&mutex_);
  return std::all_of(recordings_.begin(), recordings_.end(),
                     [](const auto& recording) { return recording->closing; });
}

UplinkHold StoreLink::FindHold() const {
  if (!has_link_ || session_ == Session::kOpen) return UplinkHold::kNone;
  // What is tried again is held for the reason of the last time, until that is over.
  const absl::Status& why = refusal_.ok() ? closed_ : refusal_;
  if (absl::IsResourceExhausted(why)) return UplinkHold::kNoRoom;
  if (absl::IsUnavailable(why) || absl::IsDeadlineExceeded(why)) return UplinkHold::kAway;
  return why.ok() ? UplinkHold::kOpening : UplinkHold::kRefused;
}

UploadStatus StoreLink::upload() const {
  UploadStatus status = queue_.status();
  status.frames = localised_.CountUnkept();
  absl::MutexLock lock(&mutex_);
  status.held_back = held_back_.status(options_.clock());
  status.refused_items = refused_items_;
  status.hold = FindHold();
  for (const auto& recording : recordings_) {
    status.refused_items += recording->recorder->refused_items();
  }
  return status;
}

}  // namespace corbslam::client_agent
