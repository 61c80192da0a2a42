#include "services/viewer/mission_feed.h"

#include <utility>
#include <vector>

#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

EncodedMessage Encode(const v1::ViewerMessage& message) {
  return std::make_shared<const std::string>(message.SerializeAsString());
}

EncodedMessage EncodeWithoutPoints(v1::ViewerMessage message) {
  for (auto& island : *message.mutable_map()->mutable_islands()) {
    island.clear_points();
    island.clear_removed_points();
  }
  return Encode(message);
}

}  // namespace

absl::Status MissionFeed::Apply(v1::WatchMapResponse changes) {
  {
    absl::MutexLock lock(&mutex_);
    if (begins_anew_) {
      begins_anew_ = false;
      mirror_.Clear();
      log_begin_ += log_.size();
      log_.clear();
      log_bytes_ = 0;
      ++generation_;
    }
    RETURN_IF_ERROR(mirror_.Apply(changes));
    v1::ViewerMessage message;
    *message.mutable_map() = std::move(changes);
    Change change;
    change.whole = Encode(message);
    change.without_points = EncodeWithoutPoints(std::move(message));
    log_bytes_ += change.bytes();
    log_.push_back(std::move(change));
    TrimLog();
  }
  CallListeners();
  return absl::OkStatus();
}

void MissionFeed::TrimLog() {
  while (log_bytes_ > options_.max_log_bytes && !log_.empty()) {
    log_bytes_ -= log_.front().bytes();
    log_.pop_front();
    ++log_begin_;
  }
}

void MissionFeed::BeginAnew() {
  absl::MutexLock lock(&mutex_);
  begins_anew_ = true;
}

void MissionFeed::AddEvent(v1::MissionEvent event) {
  {
    absl::MutexLock lock(&mutex_);
    newest_event_ = event.number();
    v1::ViewerMessage message;
    *message.mutable_event() = std::move(event);
    events_.push_back(Encode(message));
    while (events_.size() > options_.max_events) {
      events_.pop_front();
      ++events_begin_;
    }
  }
  CallListeners();
}

uint64_t MissionFeed::newest_event() const {
  absl::ReaderMutexLock lock(&mutex_);
  return newest_event_;
}

void MissionFeed::SetPulse(v1::MissionPulse pulse) {
  {
    absl::MutexLock lock(&mutex_);
    pulse_ = std::move(pulse);
    ++pulses_;
  }
  CallListeners();
}

EncodedMessage MissionFeed::Next(FeedReader& reader) const {
  absl::ReaderMutexLock lock(&mutex_);
  EncodedMessage message;
  if (reader.generation == 0) {
    message = BeginPicture(reader);
  } else {
    message = NextPulse(reader);
    if (message == nullptr) message = NextEvent(reader);
    if (message == nullptr) message = NextOfMap(reader);
  }
  if (message != nullptr) reader.sent_bytes += message->size();
  return message;
}

bool MissionFeed::IsBehind(const FeedReader& reader) const {
  return reader.generation != generation_ || reader.next_change < log_begin_;
}

EncodedMessage MissionFeed::BeginPicture(FeedReader& reader) const {
  v1::ViewerMessage message;
  v1::MapReset& reset = *message.mutable_reset();
  reset.set_reason(reader.generation == 0             ? v1::MapReset::REASON_BEGIN
                   : reader.generation != generation_ ? v1::MapReset::REASON_RECONNECTED
                                                      : v1::MapReset::REASON_SKIPPED);
  if (reset.reason() == v1::MapReset::REASON_SKIPPED) ++reader.skips;
  reset.set_keyframes(mirror_.keyframes());
  if (reader.with_points) reset.set_map_points(mirror_.points());
  reader.generation = generation_;
  reader.picture = {};
  // What changes while the picture is told follows behind it.
  reader.next_change = log_begin_ + log_.size();
  return Encode(message);
}

EncodedMessage MissionFeed::NextOfMap(FeedReader& reader) const {
  if (IsBehind(reader)) return BeginPicture(reader);
  if (!reader.picture.ended) {
    v1::ViewerMessage message;
    *message.mutable_map() =
        mirror_.NextPiece(reader.with_points, options_.items_in_a_piece, reader.picture);
    return Encode(message);
  }
  if (reader.next_change == log_begin_ + log_.size()) return nullptr;
  const Change& change = log_[reader.next_change++ - log_begin_];
  return reader.with_points ? change.whole : change.without_points;
}

EncodedMessage MissionFeed::NextEvent(FeedReader& reader) const {
  if (reader.next_event < events_begin_) reader.next_event = events_begin_;
  if (reader.next_event == events_begin_ + events_.size()) return nullptr;
  return events_[reader.next_event++ - events_begin_];
}

EncodedMessage MissionFeed::NextPulse(FeedReader& reader) const {
  if (reader.pulse == pulses_) return nullptr;
  reader.pulse = pulses_;
  v1::ViewerMessage message;
  *message.mutable_pulse() = pulse_;
  message.mutable_pulse()->set_sent_bytes(reader.sent_bytes);
  message.mutable_pulse()->set_skips(reader.skips);
  return Encode(message);
}

uint64_t MissionFeed::AddListener(std::function<void()> listener) {
  absl::MutexLock lock(&mutex_);
  listeners_[next_token_] = std::move(listener);
  return next_token_++;
}

void MissionFeed::RemoveListener(uint64_t token) {
  absl::MutexLock lock(&mutex_);
  listeners_.erase(token);
}

size_t MissionFeed::listeners() const {
  absl::ReaderMutexLock lock(&mutex_);
  return listeners_.size();
}

void MissionFeed::CallListeners() {
  std::vector<std::function<void()>> listeners;
  {
    absl::ReaderMutexLock lock(&mutex_);
    for (const auto& [token, listener] : listeners_) listeners.push_back(listener);
  }
  for (const auto& listener : listeners) listener();
}

}  // namespace corbslam::services
