// Implements the part of StoreLink that has the disk keep what is to outlive the process.
#include <algorithm>
#include <optional>
#include <vector>

#include "client_agent/link/store_link.h"

namespace corbslam::client_agent {
namespace {

// What is held back and written again and again takes no more of the disk than this.
constexpr double kHeldBytesPerSecond = 4 << 20;

}  // namespace

void StoreLink::SpillDue(bool now) {
  if (!has_link_ && IsFinishing()) {
    queue_.SpillAll();
  } else {
    queue_.Spill();
  }
  WriteHeld(now);
}

void StoreLink::WriteHeld(bool now) {
  if (!WritesAll() || (!now && options_.clock() < next_held_)) return;
  std::vector<Recording*> open;
  {
    absl::MutexLock lock(&mutex_);
    DeliverFrames();
    for (auto& recording : recordings_) {
      if (!recording->closed) open.push_back(recording.get());
    }
  }
  const bool anew = queue_.TakeHeldLost();
  for (Recording* recording : open) WriteHeldOf(*recording, anew);
}

// Only this thread takes batches, so that none comes between the copy and its record.
void StoreLink::WriteHeldOf(Recording& recording, bool anew) {
  if (anew) recording.recorder->CopyHeldAnew();
  const uint64_t changes = recording.recorder->held_changes();
  if (recording.held == changes) return;
  const HeldItems held =
      recording.map->Read([&](const Map& map) { return recording.recorder->CopyHeld(map); });
  const std::optional<uint64_t> bytes = queue_.WriteHeld(held);
  if (!bytes.has_value()) {
    recording.recorder->CopyHeldAnew();
    recording.held.reset();
    return;
  }
  recording.held = changes;
  next_held_ =
      options_.clock() + std::max(options_.spool_within / 4,
                                  absl::Seconds(static_cast<double>(*bytes) / kHeldBytesPerSecond));
}

}  // namespace corbslam::client_agent
