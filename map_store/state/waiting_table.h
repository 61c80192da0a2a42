// Keeps what waits for an item that has not arrived, found by that item and by how long it has
// waited.
#ifndef CORBSLAM_MAP_STORE_STATE_WAITING_TABLE_H_
#define CORBSLAM_MAP_STORE_STATE_WAITING_TABLE_H_

#include <cstddef>
#include <map>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/btree_set.h"
#include "absl/time/time.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

using MissingItem = std::variant<KeyframeId, MapPointId>;

// A value; not thread-safe. Each call costs as much as the entries that it concerns, not as all
// that wait. `Value` says in `since` from when on it has waited: infinite until Expire has seen it.
template <typename Key, typename Value>
class WaitingTable {
 public:
  WaitingTable() = default;
  // Takes values whose missing items nobody knows any more: all are due.
  explicit WaitingTable(std::map<Key, Value> values) {
    for (auto& [key, value] : values) {
      Put(key, std::move(value), MissingItem());
      due_.insert(key);
    }
  }

  size_t size() const { return entries_.size(); }
  // Returns a key greater than every other; for keys that are numbers.
  Key NextKey() const { return entries_.empty() ? Key() : entries_.rbegin()->first + 1; }
  std::map<Key, Value> Values() const {
    std::map<Key, Value> values;
    for (const auto& [key, entry] : entries_) values.emplace(key, entry.value);
    return values;
  }

  // Adds a value, in place of the one that the key had.
  void Put(Key key, Value value, const MissingItem& missing) {
    Erase(key);
    waits_for_[missing].insert(key);
    if (value.since == absl::InfiniteFuture()) {
      new_.insert(key);
    } else {
      by_age_.insert({value.since, key});
    }
    entries_.emplace(key, Entry{std::move(value), missing});
  }
  void Erase(Key key) {
    const auto it = entries_.find(key);
    if (it == entries_.end()) return;
    const auto waiting = waits_for_.find(it->second.missing);
    waiting->second.erase(key);
    if (waiting->second.empty()) waits_for_.erase(waiting);
    by_age_.erase({it->second.value.since, key});
    new_.erase(key);
    due_.erase(key);
    entries_.erase(it);
  }

  // The caller says that the item came, or is known never to come: what waits for it is due.
  void Release(const MissingItem& item) {
    const auto it = waits_for_.find(item);
    if (it != waits_for_.end()) due_.insert(it->second.begin(), it->second.end());
  }
  // Takes out what is due, in the order of the keys.
  std::vector<std::pair<Key, Value>> TakeDue() {
    std::vector<std::pair<Key, Value>> taken;
    for (const Key& key : std::set<Key>(due_)) {
      taken.emplace_back(key, entries_.at(key).value);
      Erase(key);
    }
    return taken;
  }

  // Forgets what has waited for longer than `limit`; returns how many values that were.
  size_t Expire(absl::Time now, absl::Duration limit) {
    for (const Key& key : new_) {
      entries_.at(key).value.since = now;
      by_age_.insert({now, key});
    }
    new_.clear();
    size_t expired = 0;
    for (; !by_age_.empty() && now - by_age_.begin()->first > limit; ++expired) {
      Erase(Key(by_age_.begin()->second));
    }
    return expired;
  }

 private:
  struct Entry {
    Value value;
    MissingItem missing;
  };

  std::map<Key, Entry> entries_;
  absl::btree_map<MissingItem, absl::btree_set<Key>> waits_for_;
  std::set<Key> due_;
  absl::btree_set<Key> new_;  // Keys of values without a `since`.
  absl::btree_set<std::pair<absl::Time, Key>> by_age_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_WAITING_TABLE_H_
