#include "tests/replay/replaying_agent.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace corbslam {
namespace {

// How soon a full queue is tried again.
constexpr absl::Duration kTryAgain = absl::Milliseconds(2);

bool IsFinal(const absl::Status& reason) {
  return absl::IsAborted(reason) || absl::IsInvalidArgument(reason) ||
         absl::IsPermissionDenied(reason);
}

}  // namespace

ReplayingAgent::ReplayingAgent(const ReplayOptions& options, const RecordedUploads* uploads,
                               std::unique_ptr<Uplink> uplink)
    : options_(options), uploads_(*uploads), start_(absl::Now()), uplink_(std::move(uplink)) {
  uint64_t keyframes = 0;
  for (const MapUpdateBatch& batch : uploads_) {
    keyframes += batch.full_keyframes.size();
    keyframes_before_end_.push_back(keyframes);
  }
  thread_ = std::thread([this] { Run(); });
}

ReplayingAgent::~ReplayingAgent() {
  Stop();
  thread_.join();
  uplink_->Close();
}

void ReplayingAgent::Stop() {
  absl::MutexLock lock(&mutex_);
  stopped_ = true;
}

absl::Status ReplayingAgent::WaitUntilDone(absl::Duration timeout) {
  absl::MutexLock lock(&mutex_);
  const bool ended =
      mutex_.AwaitWithTimeout(absl::Condition(this, &ReplayingAgent::HasEnded), timeout);
  if (!failure_.ok()) return failure_;
  if (ended) return absl::OkStatus();
  return absl::DeadlineExceededError(
      absl::StrCat(options_.agent, ": ", ledger_.acknowledged, " of ", uploads_.size(),
                   " batches are acknowledged after ", absl::FormatDuration(timeout)));
}

ReplayLedger ReplayingAgent::ledger() const {
  absl::MutexLock lock(&mutex_);
  return ledger_;
}

void ReplayingAgent::OnSessionOpened(const SessionGrant& grant) {
  absl::MutexLock lock(&mutex_);
  has_session_ = true;
  is_opening_ = false;
  ++ledger_.sessions;
  waiting_.clear();
  for (const Acknowledgement& acknowledgement : grant.acknowledged) {
    if (acknowledgement.local_map != options_.local_map) continue;
    if (acknowledgement.number < ledger_.acknowledged) {
      failure_ = absl::DataLossError(absl::StrCat(options_.agent, ": batch ", ledger_.acknowledged,
                                                  " was acknowledged, the store has ",
                                                  acknowledgement.number));
    }
    TakeAcknowledgement(acknowledgement.number);
  }
  sent_ = ledger_.acknowledged;
}

void ReplayingAgent::OnAcknowledged(const Acknowledgement& acknowledgement) {
  absl::MutexLock lock(&mutex_);
  if (acknowledgement.local_map == options_.local_map) TakeAcknowledgement(acknowledgement.number);
}

void ReplayingAgent::TakeAcknowledgement(uint64_t number) {
  const absl::Time now = absl::Now();
  for (auto it = waiting_.begin(); it != waiting_.end() && it->first <= number;) {
    if (!uploads_[it->first - 1].full_keyframes.empty()) {
      ledger_.acknowledged_after_ms.push_back(absl::ToDoubleMilliseconds(now - it->second));
    }
    it = waiting_.erase(it);
  }
  ledger_.acknowledged = std::max(ledger_.acknowledged, number);
  if (ledger_.acknowledged > 0) {
    ledger_.keyframes =
        keyframes_before_end_[std::min<size_t>(ledger_.acknowledged, uploads_.size()) - 1];
  }
}

void ReplayingAgent::OnSessionClosed(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  has_session_ = false;
  is_opening_ = false;
  open_at_ = absl::Now() + options_.retry_after;
  if (IsFinal(reason)) failure_ = reason;
}

absl::Time ReplayingAgent::DueTime(uint64_t number) const {
  if (options_.keyframes_per_s <= 0) return absl::InfinitePast();
  const auto before = number > 1 ? static_cast<double>(keyframes_before_end_[number - 2]) : 0;
  return start_ + absl::Seconds(before / options_.keyframes_per_s);
}

void ReplayingAgent::MakeSession() {
  {
    absl::MutexLock lock(&mutex_);
    is_opening_ = true;
  }
  SessionRequest request;
  request.mission = options_.mission;
  request.agent = options_.agent;
  request.local_maps = {options_.local_map};
  uplink_->Open(request, this);
}

// The batch behind the last one sent, if it is due and the store keeps up.
void ReplayingAgent::SendNext() {
  uint64_t number = 0;
  absl::Time due;
  {
    absl::MutexLock lock(&mutex_);
    number = sent_ + 1;
    if (number > uploads_.size() || waiting_.size() >= options_.max_waiting) return;
    due = DueTime(number);
    if (due > absl::Now()) return;
    // What had to wait its turn has waited, too.
    waiting_[number] = options_.keyframes_per_s > 0 ? due : absl::Now();
    sent_ = number;
  }
  const MapUpdateBatch batch = AsLocalMap(uploads_[number - 1], options_.local_map);
  if (uplink_->Send(batch)) return;
  absl::MutexLock lock(&mutex_);
  // A session that opened meanwhile has set it itself.
  if (sent_ == number) sent_ = number - 1;
  waiting_.erase(number);
}

void ReplayingAgent::Run() {
  while (true) {
    bool is_idle = true;
    bool wants_session = false;
    {
      absl::MutexLock lock(&mutex_);
      if (HasEnded()) return;
      wants_session = !has_session_ && !is_opening_ && absl::Now() >= open_at_;
      const uint64_t next = sent_ + 1;
      is_idle = !has_session_ || next > uploads_.size() ||
                waiting_.size() >= options_.max_waiting || DueTime(next) > absl::Now();
    }
    if (wants_session) {
      MakeSession();
    } else if (!is_idle) {
      SendNext();
    }
    if (is_idle) absl::SleepFor(kTryAgain);
  }
}

}  // namespace corbslam
