// The overlaps of a mission: those that were verified, that wait for fusing, and of which the graph
// is made.
#ifndef CORBSLAM_MAP_STORE_STATE_OVERLAP_LEDGER_H_
#define CORBSLAM_MAP_STORE_STATE_OVERLAP_LEDGER_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/time/time.h"
#include "slam/exchange/overlap.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

enum class OverlapState {
  kRefused,
  kWaiting,  // Accepted, not yet in the graph.
  kInGraph,
  kFailed,  // Accepted, but no worker could fuse it.
};

struct OverlapEntry {
  uint64_t id = 0;
  Overlap overlap;
  OverlapState state = OverlapState::kRefused;
  bool urgent = false;  // It disagrees with the graph as it is.
  bool alone = false;   // It was refused among others, any of which may be to blame.
  int attempts = 0;
  uint64_t revision = 0;
  absl::Time verified_at;
  std::string note;
};

// Entries by id, with indices of those that matter to fusion. The store asks for these at each
// piece of work, and a mission refuses a hundred overlaps for each that it accepts. An entry that
// waits or is in the graph is live. Of the other entries the newest kMaxHistory are kept. A value;
// not thread-safe.
class OverlapLedger {
 public:
  using Entries = std::map<uint64_t, OverlapEntry>;
  using Ids = std::set<uint64_t>;
  static constexpr size_t kMaxHistory = 2'000;

  OverlapLedger() = default;
  explicit OverlapLedger(Entries entries);

  const Entries& entries() const { return entries_; }
  bool contains(uint64_t id) const { return entries_.contains(id); }
  // The entry must be there.
  const OverlapEntry& at(uint64_t id) const { return entries_.at(id); }
  // Returns null if there is no such entry.
  const OverlapEntry* Find(uint64_t id) const;

  const Ids& waiting() const { return waiting_; }
  const Ids& in_graph() const { return in_graph_; }
  // Returns the live entries between keyframes of these two local maps, in either order.
  const Ids& LiveBetween(LocalMapId a, LocalMapId b) const;
  // Returns the live entries of which the keyframe is one end.
  const Ids& LiveAt(KeyframeId id) const;

  // Returns about how much of the heap it takes.
  uint64_t HeapBytes() const;

  // Adds an entry. Its id must be new, and the largest.
  void Add(OverlapEntry entry);
  // Changes an entry that is there; `change` may change all of it but its id and its keyframes.
  void Change(uint64_t id, absl::FunctionRef<void(OverlapEntry&)> change);

 private:
  using Pair = std::pair<LocalMapId, LocalMapId>;

  static Pair PairOf(const Overlap& overlap);
  void Index(const OverlapEntry& entry);
  void Unindex(const OverlapEntry& entry);
  void ForgetOldest();

  Entries entries_;
  Ids waiting_;
  Ids in_graph_;
  Ids history_;  // The entries that are not live.
  std::map<Pair, Ids> live_between_;
  std::map<KeyframeId, Ids> live_at_;
  uint64_t inliers_ = 0;  // Of all entries.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_OVERLAP_LEDGER_H_
