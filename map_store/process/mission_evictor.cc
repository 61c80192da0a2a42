#include "map_store/process/mission_evictor.h"

#include <glog/logging.h>

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/view/damage_text.h"
#include "slam/util/named_thread.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kEvictorStepsLower = 10;
constexpr absl::Duration kBetweenLooks = absl::Seconds(1);
// What somebody asks for every few seconds is not to be read each time.
constexpr absl::Duration kLeastRest = absl::Seconds(10);
// A snapshot that can't be written costs as much with each attempt.
constexpr absl::Duration kAfterFailedSnapshot = absl::Minutes(1);

absl::Status IsUsed(absl::string_view name) {
  return absl::FailedPreconditionError(absl::StrCat(
      "mission ", name, " stays in memory: robots are connected, or calls are under way"));
}

}  // namespace

void MissionEvictor::Start() {
  thread_ = StartThread("mission evictor", [this] { Run(); });
}

void MissionEvictor::Stop() {
  signal_.Stop();
  if (thread_.joinable()) thread_.join();
}

void MissionEvictor::Run() {
  // Robots wait for the other threads, but nobody waits for this one.
  StepBehindRobots(kEvictorStepsLower, "missions that fall asleep");
  while (signal_.WaitFor(kBetweenLooks)) {
    EvictUnused();
    // Robots were refused: they come again in a moment.
    const bool in_haste = memory_.TakeWanted();
    if (in_haste) ReturnFreeMemoryAbove(0);
    while (memory_.IsShort() && !signal_.stopped() && MakeRoom(in_haste)) {
      ReturnFreeMemory();
    }
  }
}

absl::Status MissionEvictor::Evict(absl::string_view name) {
  ASSIGN_OR_RETURN(const KnownMission known, directory_.Peek(name));
  if (!known.damage.ok()) return absl::DataLossError(SayDamage(name, known.damage));
  if (known.mission == nullptr) return absl::OkStatus();
  return TryEvict({known.name, known.mission, known.last_used}, /*in_haste=*/false,
                  [] { return true; });
}

size_t MissionEvictor::EvictUnused() {
  size_t count = 0;
  for (Unused& unused : directory_.ListUnused()) {
    if (clock_() - unused.last_used < sleep_after_ || signal_.stopped()) break;
    if (!MayTry(unused)) continue;
    const absl::Status fell =
        TryEvict(unused, /*in_haste=*/false, [this] { return !signal_.stopped(); });
    count += fell.ok() ? 1 : 0;
    // Its memory is free once the last one lets it go.
    unused.mission.reset();
  }
  return count;
}

bool MissionEvictor::MakeRoom(bool in_haste) {
  for (const Unused& unused : directory_.ListUnused()) {
    if (!in_haste && clock_() - unused.last_used < kLeastRest) break;
    if (!MayTry(unused)) continue;
    if (TryEvict(unused, in_haste, [this] { return !signal_.stopped(); }).ok()) return true;
  }
  return false;
}

void MissionEvictor::EvictAll(absl::Duration time_left) {
  const absl::Time end = clock_() + time_left;
  for (const Unused& unused : directory_.ListUnused()) {
    TryEvict(unused, /*in_haste=*/true, [this, end] { return clock_() < end; }).IgnoreError();
  }
}

absl::Status MissionEvictor::TryEvict(const Unused& unused, bool in_haste,
                                      const std::function<bool()>& goes_on) {
  absl::MutexLock one(&evicting_);
  if (!directory_.IsUnused(unused)) return IsUsed(unused.name);
  RETURN_IF_ERROR(unused.mission->CheckMaySleep());
  const auto is_unused = [&] { return goes_on() && directory_.IsUnused(unused); };
  const absl::StatusOr<uint64_t> kept = unused.mission->snapshots().KeepAll(is_unused);
  if (!kept.ok()) NoteFailure(unused, kept.status());
  RETURN_IF_ERROR(kept.status());
  if (!in_haste) journal_.TidyUp(unused.name);
  if (!directory_.BeginEviction(unused)) return IsUsed(unused.name);
  if (!unused.mission->Retire(*kept)) {
    directory_.CancelEviction(unused);
    return IsUsed(unused.name);
  }
  // A snapshot that had begun reads the journal, and a mission that is aside would be opened by
  // that.
  unused.mission->snapshots().WaitForEnd();
  PutAside(unused);
  return absl::OkStatus();
}

void MissionEvictor::PutAside(const Unused& unused) {
  EvictedMission evicted{unused.mission->Summarise(), unused.mission->events().GetPast()};
  if (int64_t& used_ns = evicted.summary.info.profile.last_used_ns; used_ns == 0) {
    used_ns = absl::ToUnixNanos(unused.last_used);
  }
  const absl::Status status = journal_.PutAside(unused.name, EncodeSummary(evicted.summary));
  LOG_IF(WARNING, !status.ok()) << "mission " << unused.name
                                << " is asleep, but the next start will read it: " << status;
  evicted.NoteEvicted(journal_.DiskBytes(unused.name));
  directory_.EndEviction(unused, std::move(evicted));
  ++evictions_;
}

bool MissionEvictor::MayTry(const Unused& unused) {
  absl::MutexLock lock(&tries_mutex_);
  const auto it = next_try_.find(unused.name);
  if (it == next_try_.end()) return true;
  if (clock_() < it->second) return false;
  next_try_.erase(it);
  return true;
}

void MissionEvictor::NoteFailure(const Unused& unused, const absl::Status& status) {
  if (absl::IsCancelled(status) || absl::IsAborted(status)) return;
  LOG(WARNING) << "mission " << unused.name << " stays in memory: " << status;
  absl::MutexLock lock(&tries_mutex_);
  next_try_[unused.name] = clock_() + kAfterFailedSnapshot;
}

}  // namespace corbslam::map_store
