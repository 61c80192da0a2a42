#include "map_store/process/memory_budget.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/resident_memory.h"

namespace corbslam::map_store {
namespace {

// Giving memory back looks at all of the heap, so that it is not done more often.
constexpr absl::Duration kBetweenTrims = absl::Seconds(10);
// The budget is short when less than one part of so many is left.
constexpr uint64_t kShortShare = 8;

}  // namespace

MemoryBudget::MemoryBudget(uint64_t limit_bytes, std::function<uint64_t()> resident_bytes,
                           std::function<absl::Time()> clock, std::function<uint64_t()> used_bytes)
    : limit_bytes_(limit_bytes),
      resident_bytes_(std::move(resident_bytes)),
      clock_(std::move(clock)),
      used_bytes_(std::move(used_bytes)) {}

uint64_t MemoryBudget::Counted() const {
  const uint64_t resident = resident_bytes_();
  return used_bytes_ == nullptr ? resident : std::min(resident, used_bytes_());
}

bool MemoryBudget::Fits(uint64_t bytes) const {
  const auto fits = [&](uint64_t there) {
    return there <= limit_bytes_ && bytes <= limit_bytes_ - there;
  };
  return fits(resident_bytes_()) || fits(Counted());
}

bool MemoryBudget::IsShort() const {
  const uint64_t short_from = limit_bytes_ - limit_bytes_ / kShortShare;
  return limit_bytes_ != 0 && resident_bytes_() > short_from && Counted() > short_from;
}

bool MemoryBudget::MakeRoomFor(uint64_t bytes) {
  if (make_room_ == nullptr) return false;
  absl::MutexLock lock(&making_room_);
  while (!Fits(bytes)) {
    if (!make_room_()) return false;
    ReturnFreeMemoryAbove(0);
  }
  return true;
}

absl::Status MemoryBudget::Check(absl::string_view what, uint64_t bytes) {
  if (limit_bytes_ == 0 || Fits(bytes)) return absl::OkStatus();
  Trim();
  if (Fits(bytes) || MakeRoomFor(bytes)) return absl::OkStatus();
  return Refuse(what, bytes);
}

absl::Status MemoryBudget::CheckAtOnce(absl::string_view what, uint64_t bytes) {
  if (limit_bytes_ == 0 || Fits(bytes)) return absl::OkStatus();
  wanted_ = true;
  return Refuse(what, bytes);
}

absl::Status MemoryBudget::Refuse(absl::string_view what, uint64_t bytes) {
  ++refused_;
  return absl::ResourceExhaustedError(
      absl::StrCat("the map store has ", Counted() >> 20, " MiB in memory of a budget of ",
                   limit_bytes_ >> 20, " MiB (--memory-budget): no room for ", what, " of ",
                   bytes >> 10, " KiB; delete a mission, or give the store more memory"));
}

void MemoryBudget::Trim() {
  {
    absl::MutexLock lock(&mutex_);
    const absl::Time now = clock_();
    if (now < next_trim_) return;
    next_trim_ = now + kBetweenTrims;
  }
  ReturnFreeMemoryAbove(0);
}

}  // namespace corbslam::map_store
