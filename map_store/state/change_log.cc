#include "map_store/state/change_log.h"

#include <algorithm>
#include <utility>

#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {
namespace {

// The changes of some seconds, in a local map that is adjusted all the time: so many times all that
// it has, but not more than a large one is worth, nor fewer than a small one soon has again.
constexpr size_t kTimesTheMap = 4;
constexpr size_t kMostItems = 100'000;
constexpr size_t kFewItems = 2'000;

template <typename Id>
void Append(const std::vector<Id>& from, std::vector<Id>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

template <typename Id>
void SortEachOnce(std::vector<Id>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

// They are kept as they are, for long.
void ShrinkToFit(ItemChanges& changes) {
  changes.keyframes.shrink_to_fit();
  changes.sights.shrink_to_fit();
  changes.points.shrink_to_fit();
  changes.landmarks.shrink_to_fit();
}

}  // namespace

void ChangeLog::Close(uint64_t version, size_t map_items) {
  if (open_.size() == 0) return;
  entries_.push_back({version, std::exchange(open_, {})});
  ShrinkToFit(entries_.back().changes);
  items_ += entries_.back().changes.size();
  const size_t room = std::clamp(kTimesTheMap * map_items, kFewItems, kMostItems);
  while (items_ > room) {
    items_ -= entries_.front().changes.size();
    known_after_ = entries_.front().version;
    entries_.pop_front();
  }
}

void ChangeLog::Forget(uint64_t version) {
  *this = ChangeLog();
  known_after_ = version;
}

std::optional<ItemChanges> ChangeLog::Since(uint64_t version) const {
  if (!Knows(version)) return std::nullopt;
  ItemChanges changes;
  for (auto it = entries_.rbegin(); it != entries_.rend() && it->version > version; ++it) {
    Append(it->changes.keyframes, changes.keyframes);
    Append(it->changes.sights, changes.sights);
    Append(it->changes.points, changes.points);
    Append(it->changes.landmarks, changes.landmarks);
  }
  SortEachOnce(changes.keyframes);
  SortEachOnce(changes.sights);
  SortEachOnce(changes.points);
  SortEachOnce(changes.landmarks);
  return changes;
}

uint64_t ChangeLog::HeapBytes() const {
  constexpr uint64_t kListsOfAnEntry = 4;
  return entries_.size() * (sizeof(Entry) + kListsOfAnEntry * HeapBlockBytes(1)) +
         items_ * sizeof(KeyframeId);
}

}  // namespace corbslam::map_store
