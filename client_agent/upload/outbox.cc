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

absl::Status Outbox::AddFound(const SpooledBatch& spooled) {
  const SpoolRecord& record = spooled.record;
  const auto [it, is_new] = local_maps_.try_emplace(record.local_map);
  LocalMapNumbers& numbers = it->second;
  if (is_new) {
    numbers.of_earlier_process = true;
    // Batches that are not in the spool any more were acknowledged.
    numbers.acknowledged = record.number - 1;
    numbers.last = record.number - 1;
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
      if (entry.batch == nullptr) released_.push_back(entry.spooled);
      continue;
    }
    if (i < sent_) ++sent_kept;
    if (kept != i) entries_[kept] = std::move(entry);
    ++kept;
  }
  entries_.resize(kept);
  sent_ = sent_kept;
}

void Outbox::Acknowledge(const Acknowledgement& acknowledgement) {
  const auto it = local_maps_.find(acknowledgement.local_map);
  if (it == local_maps_.end()) return;
  LocalMapNumbers& numbers = it->second;
  numbers.acknowledged = std::max(numbers.acknowledged, acknowledgement.number);
  DropEntries([&](const Entry& entry) {
    return entry.local_map == acknowledgement.local_map && entry.number <= acknowledgement.number;
  });
  if (numbers.closed && numbers.acknowledged >= numbers.last) local_maps_.erase(it);
}

absl::Status Outbox::CheckState(LocalMapId id, const LocalMapNumbers& numbers,
                                uint64_t stored) const {
  if (stored < numbers.acknowledged) {
    return absl::DataLossError(absl::StrCat("the map store has local map ", ToString(id),
                                            " only up to batch ", stored, " of ",
                                            numbers.acknowledged, " that it acknowledged before"));
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
  local_maps_[local_map].lost = true;
}

const Outbox::Entry* Outbox::NextUnsent() const {
  return sent_ < entries_.size() ? &entries_[sent_] : nullptr;
}

void Outbox::MarkSent() {
  const Entry& entry = entries_[sent_++];
  LocalMapNumbers& numbers = local_maps_[entry.local_map];
  numbers.sent = std::max(numbers.sent, entry.number);
}

std::shared_ptr<const MapUpdateBatch> Outbox::OldestInMemory() const {
  // Entries in the spool come before those in memory.
  const auto it = std::partition_point(entries_.begin(), entries_.end(),
                                       [](const Entry& entry) { return entry.batch == nullptr; });
  return it == entries_.end() ? nullptr : it->batch;
}

bool Outbox::MarkSpilled(const SpooledBatch& spooled) {
  const auto it = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.batch != nullptr && entry.local_map == spooled.record.local_map &&
           entry.number == spooled.record.number;
  });
  if (it == entries_.end()) {
    released_.push_back(spooled);
    return false;
  }
  bytes_ -= it->bytes;
  it->bytes = 0;
  it->batch = nullptr;
  it->spooled = spooled;
  return true;
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

bool Outbox::IsOfEarlierProcess(LocalMapId local_map) const {
  const auto it = local_maps_.find(local_map);
  return it != local_maps_.end() && it->second.of_earlier_process;
}

}  // namespace corbslam::client_agent
