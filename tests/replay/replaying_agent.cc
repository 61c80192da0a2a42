#include "tests/replay/replaying_agent.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace corbslam::tests {
namespace {

// A full queue is tried again so soon.
constexpr absl::Duration kTryAgain = absl::Milliseconds(2);

bool IsFinal(const absl::Status& reason) {
  return absl::IsAborted(reason) || absl::IsInvalidArgument(reason) ||
         absl::IsPermissionDenied(reason);
}

}  // namespace

ReplayOptions OptionsOfOne(const std::string& mission, size_t index, size_t count,
                           double keyframes_per_s) {
  ReplayOptions options;
  options.mission = mission;
  options.agent = absl::StrCat("agent", index);
  options.local_map = LocalMapId{0x1000 + index};
  options.keyframes_per_s = keyframes_per_s;
  if (keyframes_per_s > 0) {
    options.start_after =
        absl::Seconds(static_cast<double>(index) / (keyframes_per_s * static_cast<double>(count)));
  }
  return options;
}

void AppendDelays(const ReplayLedger& ledger, std::vector<double>& delays_ms) {
  for (const ReplayLedger::Delay& delay : ledger.delays) delays_ms.push_back(delay.ms());
}

ReplayingAgent::ReplayingAgent(const ReplayOptions& options, const RecordedUploads* uploads,
                               std::unique_ptr<Uplink> uplink)
    : options_(options),
      uploads_(*uploads),
      start_(absl::Now() + options.start_after),
      uplink_(std::move(uplink)) {
  uint64_t keyframes = 0;
  for (const MapUpdateBatch& batch : uploads_) {
    keyframes += batch.full_keyframes.size();
    keyframes_up_to_.push_back(keyframes);
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
      absl::StrCat(options_.agent, ": ", ledger_.acknowledged, " of ", batches(),
                   " batches are acknowledged after ", absl::FormatDuration(timeout)));
}

ReplayLedger ReplayingAgent::ledger() const {
  absl::MutexLock lock(&mutex_);
  return ledger_;
}

LocalMapId ReplayingAgent::LocalMapOf(uint64_t count) const {
  return {options_.local_map.value + (count - 1) / uploads_.size()};
}

const MapUpdateBatch& ReplayingAgent::BatchOf(uint64_t count) const {
  return uploads_[(count - 1) % uploads_.size()];
}

uint64_t ReplayingAgent::CountOf(const Acknowledgement& acknowledgement) const {
  const uint64_t lap = acknowledgement.local_map.value - options_.local_map.value;
  return lap < static_cast<uint64_t>(options_.laps) ? lap * uploads_.size() + acknowledgement.number
                                                    : 0;
}

uint64_t ReplayingAgent::KeyframesUpTo(uint64_t count) const {
  return count / uploads_.size() * keyframes_up_to_.back() +
         keyframes_up_to_[count % uploads_.size()];
}

void ReplayingAgent::OnSessionOpened(const SessionGrant& grant) {
  absl::MutexLock lock(&mutex_);
  has_session_ = true;
  is_opening_ = false;
  ++ledger_.sessions;
  waiting_.clear();
  for (const Acknowledgement& acknowledgement : grant.acknowledged) {
    const uint64_t count = CountOf(acknowledgement);
    if (count < ledger_.acknowledged) {
      failure_ = absl::DataLossError(absl::StrCat(options_.agent, ": batch ", ledger_.acknowledged,
                                                  " was acknowledged, the store has ", count));
    }
    TakeAcknowledgement(count);
  }
  sent_ = ledger_.acknowledged;
}

void ReplayingAgent::OnAcknowledged(const Acknowledgement& acknowledgement) {
  absl::MutexLock lock(&mutex_);
  TakeAcknowledgement(CountOf(acknowledgement));
}

void ReplayingAgent::OnShared(SharedUpdate update) {
  if (options_.on_shared != nullptr) options_.on_shared(update);
}

void ReplayingAgent::TakeAcknowledgement(uint64_t count) {
  const absl::Time now = absl::Now();
  for (auto it = waiting_.begin(); it != waiting_.end() && it->first <= count;) {
    if (!BatchOf(it->first).full_keyframes.empty()) {
      ledger_.delays.push_back({it->second, now});
    }
    it = waiting_.erase(it);
  }
  ledger_.acknowledged = std::max(ledger_.acknowledged, count);
  ledger_.keyframes = KeyframesUpTo(ledger_.acknowledged);
}

void ReplayingAgent::OnSessionClosed(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  has_session_ = false;
  is_opening_ = false;
  open_at_ = absl::Now() + options_.retry_after;
  if (IsFinal(reason)) failure_ = reason;
}

absl::Time ReplayingAgent::DueTime(uint64_t count) const {
  if (options_.keyframes_per_s <= 0) return absl::InfinitePast();
  return start_ +
         absl::Seconds(static_cast<double>(KeyframesUpTo(count - 1)) / options_.keyframes_per_s);
}

void ReplayingAgent::MakeSession() {
  SessionRequest request;
  {
    absl::MutexLock lock(&mutex_);
    is_opening_ = true;
    // A session opens the local map of the last acknowledged batch, or the first.
    request.local_maps = {LocalMapOf(std::max<uint64_t>(ledger_.acknowledged, 1))};
  }
  request.mission = options_.mission;
  request.agent = options_.agent;
  uplink_->Open(request, this);
}

// Sends the batch behind the last one sent, if it is due and the store keeps up.
void ReplayingAgent::SendNext() {
  uint64_t count = 0;
  absl::Time due;
  {
    absl::MutexLock lock(&mutex_);
    count = sent_ + 1;
    if (count > batches() || waiting_.size() >= options_.max_waiting) return;
    if (DueTime(count) > absl::Now()) return;
    // The delay counts the time that the batch had to wait its turn, too.
    due = options_.keyframes_per_s > 0 ? DueTime(count) : absl::Now();
    waiting_[count] = due;
    sent_ = count;
  }
  const MapUpdateBatch batch = AsLocalMap(BatchOf(count), LocalMapOf(count));
  if (options_.on_sent != nullptr) options_.on_sent(batch, due);
  if (uplink_->Send(batch)) return;
  absl::MutexLock lock(&mutex_);
  // A session that opened meanwhile has set it itself.
  if (sent_ == count) sent_ = count - 1;
  waiting_.erase(count);
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
      is_idle = !has_session_ || next > batches() || waiting_.size() >= options_.max_waiting ||
                DueTime(next) > absl::Now();
    }
    if (wants_session) {
      MakeSession();
    } else if (!is_idle) {
      SendNext();
    }
    if (is_idle) absl::SleepFor(kTryAgain);
  }
}

}  // namespace corbslam::tests
