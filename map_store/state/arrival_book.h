// The order in which a mission's local maps arrived, whatever has become of them since.
#ifndef CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_
#define CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Numbers the names of local maps as they arrive, and those of each agent on their own, from 1. One
// that became a part of another keeps its numbers, and those of a deleted one are not given again:
// a list goes on behind it, and what people call "alpha/4" is one local map for good. Is a value;
// written with the state, whose own order has gaps closed.
class ArrivalBook {
 public:
  ArrivalBook() = default;
  // Restores a book that was written, for a state from which `gone` names were gone when it was
  // begun. Names that are in `names` alone have no known agent.
  ArrivalBook(uint64_t gone, std::map<uint64_t, LocalMapId> names,
              std::map<std::string, std::vector<LocalMapId>> of_agents)
      : gone_(gone),
        next_(names.empty() ? 0 : std::prev(names.end())->first + 1),
        names_(std::move(names)),
        of_agents_(std::move(of_agents)) {
    for (const auto& [number, name] : names_) numbers_[name].of_mission = number;
    for (const auto& [agent, all] : of_agents_) {
      for (size_t i = 0; i < all.size(); ++i) numbers_[all[i]].of_agent = i + 1;
    }
  }

  void Add(LocalMapId name, const std::string& agent) {
    std::vector<LocalMapId>& all = of_agents_[agent];
    all.push_back(name);
    numbers_[name] = {next_, all.size()};
    names_.emplace(next_++, name);
  }

  // Tells books apart: one that was begun after more names had gone (for a state of an older
  // format) has other numbers.
  uint64_t gone() const { return gone_; }
  // The names by their numbers, those that are gone since included.
  const std::map<uint64_t, LocalMapId>& names() const { return names_; }
  // The names of each agent's local maps as they arrived, likewise: the first has number 1.
  const std::map<std::string, std::vector<LocalMapId>>& of_agents() const { return of_agents_; }
  // Returns the number of a name; 0 if it never arrived.
  uint64_t NumberOf(LocalMapId name) const { return NumbersOf(name).of_mission; }
  // Returns which of its agent's local maps it is, from 1; 0 if that is not known.
  uint64_t NumberOfAgent(LocalMapId name) const { return NumbersOf(name).of_agent; }

 private:
  struct Numbers {
    uint64_t of_mission = 0;
    uint64_t of_agent = 0;
  };

  Numbers NumbersOf(LocalMapId name) const {
    const auto it = numbers_.find(name);
    return it == numbers_.end() ? Numbers() : it->second;
  }

  uint64_t gone_ = 0;
  uint64_t next_ = 0;
  std::map<uint64_t, LocalMapId> names_;
  std::map<std::string, std::vector<LocalMapId>> of_agents_;
  absl::flat_hash_map<LocalMapId, Numbers> numbers_;  // Derived from the others.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_
