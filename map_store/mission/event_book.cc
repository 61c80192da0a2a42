#include "map_store/mission/event_book.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "map_store/mission/event_lines.h"

namespace corbslam::map_store {

EventBook::Past EventBook::GetPast() const {
  absl::MutexLock lock(&mutex_);
  const size_t kept = std::min(events_.size(), kMaxEventsAsleep);
  return {last_number_, {events_.end() - static_cast<std::ptrdiff_t>(kept), events_.end()}};
}

void EventBook::GoOnFrom(Past past) {
  absl::MutexLock lock(&mutex_);
  last_number_ = past.last_number;
  events_ = std::move(past.events);
}

void EventBook::Note(uint64_t revision, MissionEvent::What what) {
  std::optional<std::string> line = LineOf(mission_, what);
  MissionEvent event;
  event.time = clock_();
  event.revision = revision;
  event.what = std::move(what);
  {
    absl::MutexLock lock(&mutex_);
    event.number = ++last_number_;
    events_.push_back(std::move(event));
    if (events_.size() > kMaxEvents) events_.pop_front();
    if (line.has_value()) unlogged_.push_back(*std::move(line));
  }
  untold_ = true;
}

void EventBook::Tell() {
  if (!untold_.exchange(false)) return;
  std::vector<std::string> lines;
  {
    absl::MutexLock lock(&mutex_);
    lines.swap(unlogged_);
  }
  for (const std::string& line : lines) LOG(INFO) << line;
  listeners_.CallAllBut(0);
}

std::optional<MissionEvent> EventBook::After(uint64_t number) const {
  absl::MutexLock lock(&mutex_);
  const uint64_t known = number > last_number_ ? 0 : number;
  if (known == last_number_) return std::nullopt;
  const uint64_t oldest = events_.front().number;
  const uint64_t next = std::max(known + 1, oldest);
  MissionEvent event = events_[next - oldest];
  event.missed = next - known - 1;
  return event;
}

}  // namespace corbslam::map_store
