// Keeps items by id: walked through in the order of their ids, found by hash.
#ifndef CORBSLAM_SLAM_MAP_ITEM_TABLE_H_
#define CORBSLAM_SLAM_MAP_ITEM_TABLE_H_

#include <cstddef>
#include <map>
#include <utility>

#include "absl/container/flat_hash_map.h"

namespace corbslam {

// A value; not thread-safe. An item's address is good until the item is erased, also when the table
// is moved.
template <typename Id, typename Item>
class ItemTable {
 public:
  ItemTable() = default;
  ItemTable(const ItemTable& other) : items_(other.items_) { Index(); }
  ItemTable& operator=(const ItemTable& other) {
    if (this == &other) return *this;
    items_ = other.items_;
    Index();
    return *this;
  }
  ItemTable(ItemTable&&) noexcept = default;
  ItemTable& operator=(ItemTable&&) noexcept = default;

  const std::map<Id, Item>& items() const { return items_; }

  // Returns null when the id is unknown.
  const Item* Find(Id id) const {
    const auto it = index_.find(id);
    return it == index_.end() ? nullptr : it->second;
  }
  Item* Find(Id id) { return const_cast<Item*>(std::as_const(*this).Find(id)); }

  // Returns null, and changes nothing, if the id is there already. Adding in the order of ids is
  // fastest.
  Item* Add(Id id, Item item) {
    const auto [indexed, added] = index_.try_emplace(id, nullptr);
    if (!added) return nullptr;
    const auto it = items_.emplace_hint(items_.end(), id, std::move(item));
    indexed->second = &it->second;
    return &it->second;
  }
  // Takes over items that are none of its own; their addresses stay good.
  void Absorb(ItemTable other) {
    index_.insert(other.index_.begin(), other.index_.end());
    items_.merge(other.items_);
  }
  void Erase(Id id) {
    index_.erase(id);
    items_.erase(id);
  }

 private:
  void Index() {
    index_.clear();
    index_.reserve(items_.size());
    for (auto& [id, item] : items_) index_.emplace(id, &item);
  }

  std::map<Id, Item> items_;
  absl::flat_hash_map<Id, Item*> index_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_ITEM_TABLE_H_
