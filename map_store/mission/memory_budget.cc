#include "map_store/mission/memory_budget.h"

#include <malloc.h>

#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam::map_store {
namespace {

// Giving memory back looks at all of the heap, so that it is not done more often.
constexpr absl::Duration kBetweenTrims = absl::Seconds(10);

}  // namespace

MemoryBudget::MemoryBudget(uint64_t limit_bytes, std::function<uint64_t()> resident_bytes,
                           std::function<absl::Time()> clock)
    : limit_bytes_(limit_bytes),
      resident_bytes_(std::move(resident_bytes)),
      clock_(std::move(clock)) {}

absl::Status MemoryBudget::Check(absl::string_view what, uint64_t bytes) {
  if (limit_bytes_ == 0) return absl::OkStatus();
  uint64_t resident = resident_bytes_();
  const auto fits = [&] { return resident <= limit_bytes_ && bytes <= limit_bytes_ - resident; };
  if (fits()) return absl::OkStatus();
  Trim();
  resident = resident_bytes_();
  if (fits()) return absl::OkStatus();
  ++refused_;
  return absl::ResourceExhaustedError(
      absl::StrCat("the map store has ", resident >> 20, " MiB in memory of a budget of ",
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
  malloc_trim(0);
}

}  // namespace corbslam::map_store
