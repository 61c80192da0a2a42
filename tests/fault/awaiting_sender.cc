#include "tests/fault/awaiting_sender.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/remote/remote_uplink.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using services::MakeRemoteUplink;

AwaitingSender::AwaitingSender(const std::shared_ptr<grpc::Channel>& channel, std::string mission,
                               std::string agent)
    : mission_(std::move(mission)), agent_(std::move(agent)), uplink_(MakeRemoteUplink(channel)) {}

AwaitingSender::~AwaitingSender() { uplink_->Close(); }

absl::Status AwaitingSender::WaitForSession(absl::Time deadline) {
  {
    absl::MutexLock lock(&mutex_);
    if (!end_.has_value()) return absl::OkStatus();
    end_.reset();
    open_ = false;
  }
  SessionRequest request;
  request.mission = mission_;
  request.agent = agent_;
  uplink_->Open(request, this);
  absl::MutexLock lock(&mutex_);
  if (!mutex_.AwaitWithDeadline(absl::Condition(this, &AwaitingSender::HasSessionOrEnd),
                                deadline)) {
    return absl::DeadlineExceededError(absl::StrCat(agent_, ": no session"));
  }
  return end_.value_or(absl::OkStatus());
}

absl::Status AwaitingSender::Send(MapUpdateBatch batch, absl::Duration patience) {
  const absl::Time deadline = absl::Now() + patience;
  RETURN_IF_ERROR(WaitForSession(deadline));
  uint64_t& last = numbers_[batch.local_map];
  batch.number = last + 1;
  {
    absl::MutexLock lock(&mutex_);
    local_map_ = batch.local_map;
    awaited_ = batch.number;
    acknowledged_ = last;
  }
  // Refused only while something else waits for the network, and that is nothing of the sender's.
  while (!uplink_->Send(batch)) {
    absl::MutexLock lock(&mutex_);
    if (end_.has_value()) return *end_;
    if (absl::Now() > deadline) return absl::DeadlineExceededError("the network takes nothing");
    mutex_.AwaitWithTimeout(absl::Condition(this, &AwaitingSender::HasEnded),
                            absl::Milliseconds(5));
  }
  absl::MutexLock lock(&mutex_);
  if (!mutex_.AwaitWithDeadline(absl::Condition(this, &AwaitingSender::IsAnswered), deadline)) {
    return absl::DeadlineExceededError(absl::StrCat("batch ", batch.number, " of local map ",
                                                    ToString(batch.local_map),
                                                    " is not acknowledged"));
  }
  if (acknowledged_ < awaited_) return *end_;
  last = batch.number;
  return absl::OkStatus();
}

void AwaitingSender::OnSessionOpened(const SessionGrant&) {
  absl::MutexLock lock(&mutex_);
  open_ = true;
}

void AwaitingSender::OnAcknowledged(const Acknowledgement& acknowledgement) {
  absl::MutexLock lock(&mutex_);
  if (acknowledgement.local_map != local_map_) return;
  acknowledged_ = std::max(acknowledged_, acknowledgement.number);
}

void AwaitingSender::OnSessionClosed(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  open_ = false;
  end_ = reason;
}

}  // namespace corbslam::tests
