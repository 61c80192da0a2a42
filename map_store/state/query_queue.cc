#include "map_store/state/query_queue.h"

#include <algorithm>
#include <optional>
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

std::vector<LocalMapId> QueryQueue::WaitingLocalMaps() const {
  std::vector<LocalMapId> local_maps;
  for (const Entry& entry : entries_) {
    const LocalMapId id = entry.query.local_map;
    if (std::ranges::find(local_maps, id) == local_maps.end()) local_maps.push_back(id);
  }
  return local_maps;
}

void QueryQueue::ThinOut(LocalMapId local_map) {
  const std::vector<size_t> places = FindPlaces()[local_map];
  if (places.size() > kMostOfLocalMap) TakeNearest(places);
}

void QueryQueue::ThinOutEnded(LocalMapId local_map, absl::FunctionRef<bool(LocalMapId)> has_ended) {
  size_t of_others = 0;
  size_t own = 0;
  for (const auto& [id, places] : FindPlaces()) {
    if (id == local_map) own = places.size();
    if (id != local_map && has_ended(id)) of_others += places.size();
  }
  const size_t room = kMostOfEnded - std::min(of_others, kMostOfEnded);
  for (size_t most = std::max(room, kFewestOfEnded); own > most; --own) {
    if (!TakeNearest(FindPlaces()[local_map])) return;
  }
}

QueryQueue::PlacesByLocalMap QueryQueue::FindPlaces() const {
  PlacesByLocalMap places;
  for (size_t i = 0; i < entries_.size(); ++i) {
    places[entries_[i].query.local_map].push_back(i);
  }
  return places;
}

bool QueryQueue::TakeNearest(const std::vector<size_t>& places) {
  const auto index_at = [&](size_t i) { return entries_[places[i]].query.index; };
  std::optional<size_t> nearest;
  uint32_t least = 0;
  for (size_t i = 1; i + 1 < places.size(); ++i) {
    if (places[i] == 0) continue;
    const uint32_t gap = index_at(i + 1) - index_at(i - 1);
    if (nearest.has_value() && gap >= least) continue;
    nearest = places[i];
    least = gap;
  }
  if (!nearest.has_value()) return false;
  size_ -= entries_[*nearest].against->size() - entries_[*nearest].next;
  entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(*nearest));
  return true;
}

void QueryQueue::BringForward(LocalMapId local_map) {
  const auto first = std::ranges::find_if(
      entries_, [local_map](const Entry& entry) { return entry.query.local_map == local_map; });
  if (first == entries_.end() || first == entries_.begin()) return;
  std::rotate(entries_.begin(), first, first + 1);
  attempts_of_front_ = 0;
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
  size_ -= behind - asked->next;
  asked->next = behind;
  const bool is_done = behind == asked->against->size();
  const KeyframeId front = entries_.front().query;
  const auto end = is_done ? asked + 1 : asked;
  const auto is_before = [&task](const Entry& entry) {
    return entry.query.local_map == task.query.local_map;
  };
  for (auto it = entries_.begin(); it != end; ++it) {
    if (is_before(*it)) size_ -= it->against->size() - it->next;
  }
  entries_.erase(std::remove_if(entries_.begin(), end, is_before), end);
  if (entries_.empty() || entries_.front().query != front) front_chosen_ = false;
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
