// Implements the part of StoreLink that makes batches of what local maps have to tell, and sends
// them, as the budget allows.
#include <algorithm>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "client_agent/link/store_link.h"

namespace corbslam::client_agent {

void StoreLink::DeliverFrames() {
  for (const FrameInbox::Frame& frame : frames_.Take()) {
    if (const auto* lost = std::get_if<FrameInbox::LostFrame>(&frame)) {
      if (!recordings_.empty()) recordings_.back()->recorder->AddLostFrame(lost->timestamp_ns);
      continue;
    }
    const auto& tracked = std::get<TrackedFrame>(frame);
    for (auto& recording : recordings_) {
      if (recording->map->local_map() != tracked.reference.local_map) continue;
      recording->recorder->AddTrackedFrame(tracked);
    }
  }
}

bool StoreLink::HasNoBatch(const Recording& recording) const {
  // The queue forgets a local map that was closed and acknowledged.
  return !recording.closed && !queue_.HasBegun(recording.recorder->local_map());
}

// Before its first batch nothing of a local map is safe in the spool.
bool StoreLink::BeginsInSpool(const Recording& recording) const {
  return WritesAll() && HasNoBatch(recording);
}

bool StoreLink::FlushIsDue() const {
  const absl::Duration age = options_.clock() - last_flush_;
  if (!queue_.HasUnsent() && age >= options_.flush_interval) return true;
  if (age >= options_.backlog_flush_interval) return true;
  const bool begins =
      std::any_of(recordings_.begin(), recordings_.end(),
                  [this](const auto& recording)
                      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return BeginsInSpool(*recording); });
  if (begins && age >= options_.flush_interval) return true;
  return std::any_of(recordings_.begin(), recordings_.end(), [this](const auto& recording) {
    return !recording->closed && (recording->closing || recording->recorder->pending_keyframes() >=
                                                            options_.max_keyframes_per_batch);
  });
}

void StoreLink::TakeBatches(bool all) {
  std::vector<Recording*> open;
  std::vector<Recording*> beginning;
  {
    absl::MutexLock lock(&mutex_);
    if (!all && !FlushIsDue()) return;
    last_flush_ = options_.clock();
    DeliverFrames();
    const bool no_frames_come = !all && last_flush_ - frames_.last_added() > options_.max_hold;
    for (auto& recording : recordings_) {
      if (recording->closed) continue;
      if (BeginsInSpool(*recording)) beginning.push_back(recording.get());
      if (no_frames_come || BeginsInSpool(*recording)) recording->recorder->StopHoldingBack();
      open.push_back(recording.get());
    }
    // Under a budget the first local map may leave nothing for the others: they take turns.
    if (IsBudgeted() && open.size() > 1) {
      std::rotate(open.begin(), open.begin() + static_cast<ptrdiff_t>(turn_++ % open.size()),
                  open.end());
    }
  }
  budget_.NoteTransport(*uplink_, options_.clock());
  for (Recording* recording : open) {
    while (TakeBatchOf(*recording)) queue_.Spill();
  }
  for (Recording* recording : beginning) recording->recorder->HoldBack();
  absl::MutexLock lock(&mutex_);
  NoteHeldBack();
}

bool StoreLink::IsBudgeted() const {
  return budget_.is_bounded() && (session_ == Session::kOpen || !queue_.has_spool());
}

void StoreLink::NoteHeldBack() {
  UpdateCounts waiting = {};
  for (const auto& recording : recordings_) {
    if (recording->closed) continue;
    const UpdateCounts untold = recording->recorder->CountUntold();
    for (size_t kind = 0; kind < kUpdateKinds; ++kind) waiting[kind] += untold[kind];
  }
  held_back_.NoteWaiting(waiting, options_.clock());
}

// Moves one batch from the recorder to the outbox; returns false when there is none, no room, or no
// budget.
bool StoreLink::TakeBatchOf(Recording& recording) {
  bool closing = false;
  BatchAllowance allowance(options_.max_keyframes_per_batch);
  {
    absl::MutexLock lock(&mutex_);
    if (recording.closed || !queue_.HasRoom()) return false;
    if (IsBudgeted()) {
      // No batch is made while others are late: changes wait in the map, where they coalesce.
      if (queue_.HasUnsent() || !budget_.MayTake(options_.clock())) return false;
      allowance = budget_.Allow(options_.max_keyframes_per_batch, options_.clock());
    }
    closing = recording.closing;
    // Frames may have come since this round began: the last batch has them all.
    if (closing) DeliverFrames();
    if (closing && !std::exchange(recording.asked_for_exact_places, true)) {
      recording.recorder->AskForExactPlaces();
    }
  }
  MapUpdateBatch batch;
  if (recording.recorder->HasChanges()) {
    batch = recording.map->Read(
        [&](const Map& map) { return recording.recorder->TakeBatch(map, allowance); });
  }
  const bool last = IsEmpty(batch);
  if (last && !closing) return false;
  // What is held back is to be written for what was told now.
  next_held_back_ = absl::InfinitePast();
  absl::MutexLock lock(&mutex_);
  if (recording.closed) return false;
  batch.local_map = recording.map->local_map();
  batch.closes_local_map = last;
  recording.closed = last;
  if (last && recording.stays_open) return false;
  held_back_.NoteTaken(CountUpdates(batch));
  queue_.Push(std::move(batch));
  return !last;
}

void StoreLink::SendUnsent() {
  if (options_.localise_only) SendLocalised(/*all=*/false);
  while (true) {
    {
      absl::MutexLock lock(&mutex_);
      if (session_ != Session::kOpen) return;
    }
    budget_.NoteTransport(*uplink_, options_.clock());
    if (!budget_.MaySend(options_.clock())) return;
    const uint64_t before = uplink_->bytes_up() + uplink_->bytes_waiting();
    std::vector<LostLocalMap> lost;
    const std::shared_ptr<const MapUpdateBatch> batch = queue_.TakeUnsent(lost);
    if (!lost.empty()) {
      absl::MutexLock lock(&mutex_);
      GiveUp(lost);
    }
    if (batch == nullptr) return;
    if (!uplink_->Send(*batch)) {
      queue_.MarkUnsent();
      return;
    }
    const uint64_t after = uplink_->bytes_up() + uplink_->bytes_waiting();
    budget_.NoteSent(*batch, after - std::min(after, before));
    pictures_.NoteSent(*batch);
  }
}

void StoreLink::SendPictures() {
  {
    absl::MutexLock lock(&mutex_);
    if (session_ != Session::kOpen || queue_.HasUnsent()) return;
  }
  pictures_.SendTo(*uplink_, budget_, options_.clock());
}

}  // namespace corbslam::client_agent
