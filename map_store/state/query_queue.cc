#include "map_store/state/query_queue.h"

#include <algorithm>
#include <tuple>

namespace corbslam::map_store {

QueryQueue::QueryQueue(const std::vector<QueryTask>& tasks) {
  for (size_t begin = 0; begin < tasks.size();) {
    std::vector<LocalMapId> against;
    size_t end = begin;
    for (; end < tasks.size() && tasks[end].query == tasks[begin].query; ++end) {
      against.push_back(tasks[end].against);
    }
    Push(tasks[begin].query, against);
    begin = end;
  }
  if (!tasks.empty()) attempts_of_front_ = tasks.front().attempts;
}

QueryTask QueryQueue::front() const {
  const Entry& entry = entries_.front();
  return {entry.query, (*entry.against)[entry.next], attempts_of_front_};
}

std::vector<LocalMapId> QueryQueue::AgainstOfFront() const {
  const Entry& entry = entries_.front();
  return {entry.against->begin() + static_cast<std::ptrdiff_t>(entry.next), entry.against->end()};
}

void QueryQueue::Push(KeyframeId query, const std::vector<LocalMapId>& against) {
  if (against.empty()) return;
  const bool as_before = !entries_.empty() && *entries_.back().against == against;
  entries_.push_back({query,
                      as_before ? entries_.back().against
                                : std::make_shared<const std::vector<LocalMapId>>(against),
                      0});
  size_ += against.size();
}

void QueryQueue::PopFront() {
  Entry& entry = entries_.front();
  if (++entry.next == entry.against->size()) {
    entries_.pop_front();
    front_chosen_ = false;
  }
  --size_;
  attempts_of_front_ = 0;
}

void QueryQueue::ChooseOfFront(const std::vector<LocalMapId>& against) {
  Entry& entry = entries_.front();
  size_ -= entry.against->size() - entry.next;
  size_ += against.size();
  attempts_of_front_ = 0;
  front_chosen_ = false;
  if (against.empty()) {
    entries_.pop_front();
    return;
  }
  entry = {entry.query, std::make_shared<const std::vector<LocalMapId>>(against), 0};
  front_chosen_ = true;
}

void QueryQueue::TakeUntil(const QueryTask& task) {
  const auto find = [&task](const Entry& entry) {
    return std::find(entry.against->begin() + static_cast<std::ptrdiff_t>(entry.next),
                     entry.against->end(), task.against);
  };
  const auto asked = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.query == task.query && find(entry) != entry.against->end();
  });
  if (asked == entries_.end()) return;
  const auto behind = static_cast<size_t>(find(*asked) - asked->against->begin()) + 1;
  for (auto it = entries_.begin(); it != asked; ++it) size_ -= it->against->size() - it->next;
  size_ -= behind - asked->next;
  if (asked != entries_.begin() || behind == asked->against->size()) front_chosen_ = false;
  asked->next = behind;
  entries_.erase(entries_.begin(), behind == asked->against->size() ? asked + 1 : asked);
  attempts_of_front_ = 0;
}

void QueryQueue::Clear() { *this = QueryQueue(); }

std::vector<QueryTask> QueryQueue::ToTasks() const {
  std::vector<QueryTask> tasks;
  tasks.reserve(size_);
  for (const Entry& entry : entries_) {
    for (size_t i = entry.next; i < entry.against->size(); ++i) {
      tasks.push_back({entry.query, (*entry.against)[i], 0});
    }
  }
  if (!tasks.empty()) tasks.front().attempts = attempts_of_front_;
  return tasks;
}

std::map<std::pair<LocalMapId, LocalMapId>, uint64_t> QueryQueue::CountByPair() const {
  // Entries that stand at the same place of the same list are counted before it is walked.
  std::map<std::tuple<LocalMapId, LocalMaps, size_t>, uint64_t> alike;
  for (const Entry& entry : entries_) ++alike[{entry.query.local_map, entry.against, entry.next}];
  std::map<std::pair<LocalMapId, LocalMapId>, uint64_t> counts;
  for (const auto& [kind, count] : alike) {
    const auto& [query, against, next] = kind;
    for (size_t i = next; i < against->size(); ++i) counts[{query, (*against)[i]}] += count;
  }
  return counts;
}

}  // namespace corbslam::map_store
