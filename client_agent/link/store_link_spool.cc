// Implements the part of StoreLink that has the disk keep what is to outlive the process.
#include <algorithm>
#include <optional>
#include <vector>

#include "client_agent/link/store_link.h"

namespace corbslam::client_agent {
namespace {

// What is held back and written again and again takes no more of the disk than this.
constexpr double kHeldBackBytesPerSecond = 4 << 20;

}  // namespace

void StoreLink::SpillDue(bool now) {
  if (!has_link_ && IsFinishing()) {
    queue_.SpillAll();
  } else {
    queue_.Spill();
  }
  WriteHeldBack(now);
}

void StoreLink::WriteHeldBack(bool now) {
  if (!WritesAll() || (!now && options_.clock() < next_held_back_)) return;
  std::vector<Recording*> open;
  {
    absl::MutexLock lock(&mutex_);
    DeliverFrames();
    for (auto& recording : recordings_) {
      if (!recording->closed) open.push_back(recording.get());
    }
  }
  const bool anew = queue_.TakeHeldBackLost();
  for (Recording* recording : open) WriteHeldBackOf(*recording, anew);
}

// Only this thread takes batches, so that none comes between the copy and its record.
void StoreLink::WriteHeldBackOf(Recording& recording, bool anew) {
  if (anew) recording.recorder->CopyHeldBackAnew();
  const uint64_t changes = recording.recorder->held_back_changes();
  if (recording.held_back == changes) return;
  const HeldBackItems held_back =
      recording.map->Read([&](const Map& map) { return recording.recorder->CopyHeldBack(map); });
  const std::optional<uint64_t> bytes = queue_.WriteHeldBack(held_back);
  if (!bytes.has_value()) {
    recording.recorder->CopyHeldBackAnew();
    recording.held_back.reset();
    return;
  }
  recording.held_back = changes;
  next_held_back_ = options_.clock() +
                    std::max(options_.spool_within / 4,
                             absl::Seconds(static_cast<double>(*bytes) / kHeldBackBytesPerSecond));
}

}  // namespace corbslam::client_agent
