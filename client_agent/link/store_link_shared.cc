// Implements the part of StoreLink that hears what others made, and hands it to the mapping thread.
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "client_agent/link/store_link.h"

namespace corbslam::client_agent {

std::shared_ptr<SharedInbox> StoreLink::CurrentInbox() const {
  absl::MutexLock lock(&mutex_);
  return inbox_;
}

void StoreLink::OnCorrected(LocalMapId local_map, const OwnCorrection& correction,
                            GuardedMap& map) {
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  if (inbox != nullptr && inbox->local_map() == local_map) inbox->Correct(correction, map);
}

void StoreLink::LeaveOut(const MapContradiction& found) {
  std::shared_ptr<SharedInbox> inbox;
  {
    absl::MutexLock lock(&mutex_);
    const bool is_known = std::ranges::any_of(left_out_, [&](const MapContradiction& known) {
      return known.local_map == found.local_map;
    });
    if (is_known) return;
    left_out_.push_back(found);
    inbox = inbox_;
    wake_ = true;
  }
  if (inbox != nullptr) inbox->LeaveOut(found.local_map);
}

void StoreLink::Share(LocalMapId for_local_map, SharedUpdate update) {
  ArrivedUpdate arrived = Prepare(std::move(update));
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  if (inbox != nullptr && inbox->local_map() == for_local_map) inbox->Add(std::move(arrived));
}

void StoreLink::AskAnew(double radius_m) {
  const size_t held = shared_keyframes();
  absl::MutexLock lock(&mutex_);
  if (session_ != Session::kOpen || reopen_ || anew_.is_waiting()) return;
  share_.radius_m = radius_m;
  anew_.Begin(held);
  reopen_ = true;
  wake_ = true;
}

void StoreLink::PlaceAnew() {
  std::vector<ArrivedUpdate> ready;
  std::shared_ptr<SharedInbox> inbox;
  {
    absl::MutexLock lock(&mutex_);
    ready = anew_.TakeDue(options_.clock());
    inbox = inbox_;
  }
  if (inbox != nullptr) inbox->AddAll(std::move(ready));
}

// Computes the words on the thread that hears the update, because they take time that the mapping
// thread does not have: keyframes would wait for it.
ArrivedUpdate StoreLink::Prepare(SharedUpdate update) const {
  ArrivedUpdate arrived;
  for (const SharedKeyframe& keyframe : update.keyframes) {
    arrived.words.push_back(compute_words_(keyframe.payload->features.descriptors));
  }
  arrived.update = std::move(update);
  return arrived;
}

bool StoreLink::IsUnknownToStore(LocalMapId local_map) const {
  return std::any_of(
      recordings_.begin(), recordings_.end(),
      [this, local_map](const auto& recording) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return recording->map->local_map() == local_map && HasNoBatch(*recording);
      });
}

void StoreLink::OnShared(SharedUpdate update) {
  ArrivedUpdate arrived = Prepare(std::move(update));
  std::shared_ptr<SharedInbox> inbox;
  std::optional<LinkEvent> event;
  std::vector<ArrivedUpdate> ready;
  {
    absl::MutexLock lock(&mutex_);
    // The rest of the updates for a map that has ended will be told again for the one that goes on.
    if (session_ != Session::kOpen || reopen_) return;
    // Until it has a batch of the local map, the store still tells of the one before, in that one's
    // frame. All will be told again then. A store that does not name the local map is known to do
    // so until one is made.
    const LocalMapId told = arrived.update.local_map;
    if (told.IsValid() && told != inbox_->local_map()) return;
    if (IsUnknownToStore(inbox_->local_map())) return;
    last_revision_ = arrived.update.revision;
    ++shared_updates_;
    inbox = inbox_;
    event = share_watch_.Add(arrived.update);
    if (anew_.is_waiting()) {
      ready = anew_.Add(std::move(arrived), options_.clock());
    } else {
      ready.push_back(std::move(arrived));
    }
  }
  inbox->AddAll(std::move(ready));
  if (event.has_value()) Tell(*event, inbox->local_map());
}

void StoreLink::Tell(LinkEvent event, LocalMapId local_map) const {
  if (options_.on_event) options_.on_event(event, local_map);
}

std::optional<Similarity3d> StoreLink::GlobalFromLocal(uint64_t corrections) const {
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  return inbox == nullptr ? std::nullopt : inbox->GlobalFromLocal(corrections);
}

bool StoreLink::GlobalIsInMetres() const {
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  return inbox != nullptr && inbox->GlobalIsInMetres();
}

uint64_t StoreLink::shared_updates() const {
  absl::MutexLock lock(&mutex_);
  return shared_updates_;
}

size_t StoreLink::shared_keyframes() const {
  const std::shared_ptr<SharedInbox> inbox = CurrentInbox();
  return inbox == nullptr ? 0 : inbox->keyframes();
}

}  // namespace corbslam::client_agent
