#include "client_agent/upload/held_back.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {

UpdateCounts CountUpdates(const MapUpdateBatch& batch) {
  return {batch.light_keyframes.size() + batch.tracked_frames.size() + batch.lost_frames_ns.size(),
          batch.full_keyframes.size(), batch.full_points.size(), batch.light_points.size()};
}

std::string ToString(const UpdateCounts& counts) {
  constexpr std::array<const char*, kUpdateKinds> kWords = {"poses", "keyframes", "points",
                                                            "light points"};
  std::string text;
  for (size_t kind = 0; kind < kUpdateKinds; ++kind) {
    if (counts[kind] == 0) continue;
    absl::StrAppend(&text, text.empty() ? "" : ", ", counts[kind], " ", kWords[kind]);
  }
  return text.empty() ? "nothing" : text;
}

void HeldBackWatch::NoteTaken(const UpdateCounts& taken) {
  for (size_t kind = 0; kind < kUpdateKinds; ++kind) kinds_[kind].taken += taken[kind];
}

void HeldBackWatch::NoteWaiting(const UpdateCounts& waiting, absl::Time now) {
  for (size_t i = 0; i < kUpdateKinds; ++i) {
    Kind& kind = kinds_[i];
    kind.waiting = waiting[i];
    const uint64_t arrived = kind.taken + waiting[i];
    // Some items may have gone untold: a keyframe that was culled, a point that stayed in its
    // place.
    while (!kind.marks.empty() && kind.marks.back().arrived > arrived) kind.marks.pop_back();
    if (kind.marks.empty() || kind.marks.back().arrived < arrived) {
      kind.marks.push_back({arrived, now});
    }
    while (!kind.marks.empty() && kind.marks.front().arrived <= kind.taken) kind.marks.pop_front();
  }
}

HeldBack HeldBackWatch::status(absl::Time now) const {
  HeldBack held;
  for (size_t i = 0; i < kUpdateKinds; ++i) {
    held.items[i] = kinds_[i].waiting;
    if (kinds_[i].marks.empty()) continue;
    held.waited[i] = std::max(absl::ZeroDuration(), now - kinds_[i].marks.front().time);
  }
  return held;
}

}  // namespace corbslam::client_agent
