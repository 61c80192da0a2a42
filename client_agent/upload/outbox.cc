#include "client_agent/upload/outbox.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/spool/batch_bytes.h"

namespace corbslam::client_agent {

bool IsEmpty(const MapUpdateBatch& batch) {
  return batch.cameras.empty() && batch.full_keyframes.empty() && batch.full_points.empty() &&
         batch.light_keyframes.empty() && batch.light_points.empty() &&
         batch.replacements.empty() && batch.observations.empty() && batch.removed_points.empty() &&
         batch.removed_keyframes.empty() && batch.loop_edges.empty() &&
         batch.tracked_frames.empty() && batch.lost_frames_ns.empty() && !batch.closes_local_map;
}

uint64_t Outbox::SpooledBytes() const {
  uint64_t bytes = 0;
  for (const Entry& entry : entries_) {
    if (entry.spooled.has_value()) bytes += entry.spooled->record.bytes;
  }
  return bytes;
}

absl::Status Outbox::AddFound(const SpooledBatch& spooled) {
  const SpoolRecord& record = spooled.record;
  const bool is_of_snapshot = record.kind != SpoolRecord::Kind::kBatch;
  const auto [it, is_new] = local_maps_.try_emplace(record.local_map);
  LocalMapNumbers& numbers = it->second;
  if (is_new) {
    numbers.of_earlier_process = true;
    // Batches that are not in the spool any more were acknowledged.
    numbers.acknowledged = record.number - (is_of_snapshot ? 0 : 1);
    numbers.last = numbers.acknowledged;
  }
  if (is_of_snapshot) {
    // A snapshot stands for what was acknowledged.
    numbers.acknowledged = std::max(numbers.acknowledged, record.number);
    numbers.last = std::max(numbers.last, record.number);
    numbers.acknowledged_batches.push_back(spooled);
    return absl::OkStatus();
  }
  if (record.number != numbers.last + 1) {
    released_.push_back(spooled);
    if (record.number <= numbers.last) return absl::OkStatus();
    return absl::DataLossError(absl::StrCat("the spool has batch ", record.number, " of local map ",
                                            ToString(record.local_map), " but not batch ",
                                            numbers.last + 1, ", so that it can't be sent"));
  }
  numbers.last = record.number;
  numbers.closed = record.closes_local_map;
  entries_.push_back({record.local_map, record.number, nullptr, spooled, 0});
  return absl::OkStatus();
}

bool Outbox::GoOnWith(LocalMapId local_map) {
  const auto it = local_maps_.find(local_map);
  if (it == local_maps_.end()) return false;
  LocalMapNumbers& numbers = it->second;
  if (!numbers.of_earlier_process || numbers.closed || numbers.lost) return false;
  numbers.of_earlier_process = false;
  numbers.sent = numbers.found = numbers.last;
  numbers.goes_on = numbers.keeps = true;
  return true;
}

void Outbox::Keep(LocalMapId local_map) { local_maps_[local_map].keeps = true; }

void Outbox::StopKeeping(LocalMapId local_map) {
  const auto it = local_maps_.find(local_map);
  if (it == local_maps_.end() || !std::exchange(it->second.keeps, false)) return;
  std::vector<SpooledBatch> kept = std::exchange(it->second.acknowledged_batches, {});
  for (const SpooledBatch& spooled : kept) KeepOrRelease(it->second, spooled);
}

void Outbox::KeepOrRelease(LocalMapNumbers& numbers, const SpooledBatch& spooled) {
  if (!numbers.keeps && !marks_open_) {
    released_.push_back(spooled);
    return;
  }
  if (!numbers.keeps) ReleaseAcknowledged(numbers);
  numbers.acknowledged_batches.push_back(spooled);
}

void Outbox::ReleaseAcknowledged(LocalMapNumbers& numbers) {
  released_.insert(released_.end(), numbers.acknowledged_batches.begin(),
                   numbers.acknowledged_batches.end());
  numbers.acknowledged_batches.clear();
}

std::vector<SpooledBatch> Outbox::AcknowledgedBatches(LocalMapId local_map) const {
  const auto it = local_maps_.find(local_map);
  return it == local_maps_.end() ? std::vector<SpooledBatch>() : it->second.acknowledged_batches;
}

std::vector<Outbox::Entry> Outbox::EntriesOf(LocalMapId local_map) const {
  std::vector<Entry> entries;
  for (const Entry& entry : entries_) {
    if (entry.local_map == local_map) entries.push_back(entry);
  }
  return entries;
}

void Outbox::ReplaceAcknowledged(LocalMapId local_map, const std::vector<SpooledBatch>& snapshot) {
  const auto it = local_maps_.find(local_map);
  if (it == local_maps_.end() || snapshot.empty() || !it->second.keeps) {
    released_.insert(released_.end(), snapshot.begin(), snapshot.end());
    return;
  }
  std::vector<SpooledBatch> before = std::exchange(it->second.acknowledged_batches, snapshot);
  for (const SpooledBatch& spooled : before) {
    const bool is_later = spooled.record.kind == SpoolRecord::Kind::kBatch &&
                          spooled.record.number > snapshot.back().record.number;
    (is_later ? it->second.acknowledged_batches : released_).push_back(spooled);
  }
}

void Outbox::Push(MapUpdateBatch batch) {
  LocalMapNumbers& numbers = local_maps_[batch.local_map];
  if (numbers.lost) return;
  batch.number = ++numbers.last;
  numbers.closed = batch.closes_local_map;
  Entry entry;
  entry.local_map = batch.local_map;
  entry.number = batch.number;
  entry.bytes = ApproximateBytes(batch);
  entry.batch = std::make_shared<const MapUpdateBatch>(std::move(batch));
  bytes_ += entry.bytes;
  entries_.push_back(std::move(entry));
}

template <typename Goes>
void Outbox::DropEntries(const Goes& goes) {
  size_t kept = 0;
  size_t sent_kept = 0;
  for (size_t i = 0; i < entries_.size(); ++i) {
    Entry& entry = entries_[i];
    if (goes(entry)) {
      bytes_ -= entry.bytes;
      if (entry.spooled.has_value()) {
        KeepOrRelease(local_maps_[entry.local_map], *entry.spooled);
      }
      continue;
    }
    if (i < sent_) ++sent_kept;
    if (kept != i) entries_[kept] = std::move(entry);
    ++kept;
  }
  entries_.resize(kept);
  sent_ = sent_kept;
}

void Outbox::DropAcknowledged(LocalMapId local_map, uint64_t number, LocalMapNumbers& numbers) {
  const auto goes = [&](const Entry& entry) {
    return entry.local_map == local_map && entry.number <= number;
  };
  // A local map's entries lie in the order of their numbers: what is behind `end` stays.
  size_t end = 0;
  for (size_t i = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (entry.local_map == local_map && entry.number > number) break;
    if (!goes(entry)) continue;
    end = i + 1;
    bytes_ -= entry.bytes;
    if (entry.spooled.has_value()) KeepOrRelease(numbers, *entry.spooled);
    if (entry.number == number) break;
  }
  // What stays of those before `end` moves up to it, so that the front can go: that is what other
  // local maps have under way, and never all that waits.
  size_t gone = end;
  size_t sent_gone = 0;
  for (size_t i = end; i-- > 0;) {
    if (goes(entries_[i])) {
      sent_gone += i < sent_ ? 1 : 0;
    } else if (--gone != i) {
      entries_[gone] = std::move(entries_[i]);
    }
  }
  entries_.erase(entries_.begin(), entries_.begin() + static_cast<ptrdiff_t>(gone));
  sent_ -= sent_gone;
}

void Outbox::Acknowledge(const Acknowledgement& acknowledgement) {
  const auto it = local_maps_.find(acknowledgement.local_map);
  if (it == local_maps_.end()) return;
  LocalMapNumbers& numbers = it->second;
  const uint64_t number = std::min(acknowledgement.number, numbers.last);
  if (number > numbers.acknowledged) {
    numbers.acknowledged = number;
    DropAcknowledged(acknowledgement.local_map, number, numbers);
  }
  if (!numbers.closed || numbers.acknowledged < numbers.last) return;
  ReleaseAcknowledged(numbers);
  local_maps_.erase(it);
}

absl::Status Outbox::CheckState(LocalMapId id, const LocalMapNumbers& numbers,
                                uint64_t stored) const {
  if (stored < numbers.acknowledged) {
    return absl::DataLossError(absl::StrCat("the map store has local map ", ToString(id),
                                            " only up to batch ", stored, " of ",
                                            numbers.acknowledged, " that it acknowledged before"));
  }
  if (stored > numbers.sent && numbers.goes_on) {
    return absl::DataLossError(absl::StrCat("the map store has batch ", stored, " of local map ",
                                            ToString(id),
                                            ", but the robot's spool had it only up to batch ",
                                            numbers.found, " when the robot went on with it"));
  }
  if (stored > numbers.sent && !numbers.of_earlier_process) {
    return absl::AlreadyExistsError(
        absl::StrCat("the map store has batch ", stored, " of local map ", ToString(id),
                     ", of which ", numbers.sent, " were sent: the id is another one's"));
  }
  return absl::OkStatus();
}

void Outbox::CloseEarlier(LocalMapId id, uint64_t stored, LocalMapNumbers& numbers) {
  if (!numbers.of_earlier_process || numbers.closed) return;
  // The process may have sent more than it had spilled when it ended.
  numbers.last = std::max(numbers.last, stored);
  MapUpdateBatch last;
  last.local_map = id;
  last.closes_local_map = true;
  Push(std::move(last));
}

std::vector<LostLocalMap> Outbox::Resume(const SessionGrant& grant) {
  std::vector<LostLocalMap> lost;
  for (const Acknowledgement& stored : grant.acknowledged) {
    const auto it = local_maps_.find(stored.local_map);
    if (it == local_maps_.end() || it->second.lost) continue;
    const bool of_earlier_process = it->second.of_earlier_process;
    absl::Status state = CheckState(stored.local_map, it->second, stored.number);
    if (!state.ok()) {
      lost.push_back({stored.local_map, of_earlier_process, std::move(state)});
      Drop(stored.local_map);
      continue;
    }
    CloseEarlier(stored.local_map, stored.number, it->second);
    Acknowledge(stored);
  }
  sent_ = 0;
  return lost;
}

void Outbox::Drop(LocalMapId local_map) {
  DropEntries([local_map](const Entry& entry) { return entry.local_map == local_map; });
  LocalMapNumbers& numbers = local_maps_[local_map];
  ReleaseAcknowledged(numbers);
  numbers.lost = true;
}

const Outbox::Entry* Outbox::NextUnsent() const {
  return sent_ < entries_.size() ? &entries_[sent_] : nullptr;
}

void Outbox::MarkSent() {
  const Entry& entry = entries_[sent_++];
  LocalMapNumbers& numbers = local_maps_[entry.local_map];
  numbers.sent = std::max(numbers.sent, entry.number);
}

const Outbox::Entry* Outbox::OldestInMemory() const {
  // Entries that are in the spool alone come before all others.
  const auto it = std::partition_point(entries_.begin(), entries_.end(),
                                       [](const Entry& entry) { return entry.batch == nullptr; });
  return it == entries_.end() ? nullptr : &*it;
}

const Outbox::Entry* Outbox::OldestUnwritten() const {
  const auto it = std::partition_point(entries_.begin(), entries_.end(), [](const Entry& entry) {
    return entry.spooled.has_value();
  });
  return it == entries_.end() ? nullptr : &*it;
}

Outbox::Entry* Outbox::Find(LocalMapId local_map, uint64_t number, const Entry* likely) {
  if (likely != nullptr && likely->local_map == local_map && likely->number == number) {
    return const_cast<Entry*>(likely);
  }
  const auto it = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.local_map == local_map && entry.number == number;
  });
  return it == entries_.end() ? nullptr : &*it;
}

bool Outbox::MarkWritten(const SpooledBatch& spooled) {
  const auto numbers = local_maps_.find(spooled.record.local_map);
  Entry* entry = Find(spooled.record.local_map, spooled.record.number, OldestUnwritten());
  if (entry != nullptr) {
    entry->spooled = spooled;
    return true;
  }
  // It was acknowledged meanwhile, or its local map given up.
  if (numbers == local_maps_.end() || numbers->second.lost) {
    released_.push_back(spooled);
  } else {
    KeepOrRelease(numbers->second, spooled);
  }
  return false;
}

void Outbox::Evict(LocalMapId local_map, uint64_t number) {
  Entry* entry = Find(local_map, number, OldestInMemory());
  if (entry == nullptr || !entry->spooled.has_value()) return;
  bytes_ -= entry->bytes;
  entry->bytes = 0;
  entry->batch = nullptr;
}

void Outbox::MarkUnwritten(uint64_t order) {
  for (Entry& entry : entries_) {
    if (entry.batch == nullptr || !entry.spooled.has_value() || entry.spooled->order <= order) {
      continue;
    }
    released_.push_back(*entry.spooled);
    entry.spooled.reset();
  }
}

std::vector<LocalMapId> Outbox::local_maps() const {
  std::vector<LocalMapId> ids;
  for (const auto& [id, numbers] : local_maps_) {
    if (!numbers.lost) ids.push_back(id);
  }
  return ids;
}

std::optional<LocalMapId> Outbox::OldestLocalMap() const {
  if (entries_.empty()) return std::nullopt;
  return entries_.front().local_map;
}

uint64_t Outbox::LastNumber(LocalMapId local_map) const {
  const auto it = local_maps_.find(local_map);
  return it == local_maps_.end() ? 0 : it->second.last;
}

bool Outbox::IsOfEarlierProcess(LocalMapId local_map) const {
  const auto it = local_maps_.find(local_map);
  return it != local_maps_.end() && it->second.of_earlier_process;
}

}  // namespace corbslam::client_agent
