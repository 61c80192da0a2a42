#include "map_store/state/overlap_ledger.h"

#include <algorithm>

#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {
namespace {

bool IsLive(OverlapState state) {
  return state == OverlapState::kWaiting || state == OverlapState::kInGraph;
}

using Ids = OverlapLedger::Ids;

template <typename Key>
const Ids& IdsAt(const Key& key, const std::map<Key, Ids>& index) {
  static const Ids& none = *new Ids();
  const auto it = index.find(key);
  return it == index.end() ? none : it->second;
}

template <typename Key>
void RemoveAt(const Key& key, uint64_t id, std::map<Key, Ids>& index) {
  const auto it = index.find(key);
  if (it == index.end()) return;
  it->second.erase(id);
  if (it->second.empty()) index.erase(it);
}

}  // namespace

OverlapLedger::OverlapLedger(Entries entries) : entries_(std::move(entries)) {
  for (const auto& [id, entry] : entries_) Index(entry);
  ForgetOldest();
}

const OverlapEntry* OverlapLedger::Find(uint64_t id) const {
  const auto it = entries_.find(id);
  return it == entries_.end() ? nullptr : &it->second;
}

OverlapLedger::Pair OverlapLedger::PairOf(const Overlap& overlap) {
  return std::minmax(overlap.query.local_map, overlap.candidate.local_map);
}

const OverlapLedger::Ids& OverlapLedger::LiveBetween(LocalMapId a, LocalMapId b) const {
  return IdsAt(Pair(std::minmax(a, b)), live_between_);
}

const OverlapLedger::Ids& OverlapLedger::LiveAt(KeyframeId id) const { return IdsAt(id, live_at_); }

void OverlapLedger::Add(OverlapEntry entry) {
  const uint64_t id = entry.id;
  Index(entries_.emplace(id, std::move(entry)).first->second);
  ForgetOldest();
}

void OverlapLedger::Change(uint64_t id, absl::FunctionRef<void(OverlapEntry&)> change) {
  OverlapEntry& entry = entries_.at(id);
  Unindex(entry);
  change(entry);
  Index(entry);
  ForgetOldest();
}

uint64_t OverlapLedger::HeapBytes() const {
  return TreeBytes<Entries::value_type>(entries_.size()) + entries_.size() * HeapBlockBytes(1) +
         inliers_ * sizeof(PointPair) +
         TreeBytes<uint64_t>(entries_.size() + waiting_.size() + in_graph_.size()) +
         TreeBytes<decltype(live_between_)::value_type>(live_between_.size()) +
         TreeBytes<decltype(live_at_)::value_type>(live_at_.size()) +
         TreeBytes<uint64_t>(2 * (waiting_.size() + in_graph_.size()));
}

void OverlapLedger::Index(const OverlapEntry& entry) {
  inliers_ += entry.overlap.inliers.size();
  if (!IsLive(entry.state)) {
    history_.insert(entry.id);
    return;
  }
  (entry.state == OverlapState::kWaiting ? waiting_ : in_graph_).insert(entry.id);
  live_between_[PairOf(entry.overlap)].insert(entry.id);
  live_at_[entry.overlap.query].insert(entry.id);
  live_at_[entry.overlap.candidate].insert(entry.id);
}

void OverlapLedger::Unindex(const OverlapEntry& entry) {
  inliers_ -= entry.overlap.inliers.size();
  waiting_.erase(entry.id);
  in_graph_.erase(entry.id);
  history_.erase(entry.id);
  RemoveAt(PairOf(entry.overlap), entry.id, live_between_);
  RemoveAt(entry.overlap.query, entry.id, live_at_);
  RemoveAt(entry.overlap.candidate, entry.id, live_at_);
}

void OverlapLedger::ForgetOldest() {
  while (history_.size() > kMaxHistory) {
    const auto oldest = entries_.find(*history_.begin());
    Unindex(oldest->second);
    entries_.erase(oldest);
  }
}

}  // namespace corbslam::map_store
