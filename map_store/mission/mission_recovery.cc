// Mission and its journal: what it reads at its start, and its snapshots.
#include <map>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "map_store/archive/state_archive.h"
#include "map_store/mission/mission.h"
#include "map_store/records/record_application.h"
#include "map_store/records/unrecorded_state.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Above all versions that watchers may have seen before.
constexpr uint64_t kVersionsOfALife = uint64_t{1} << 40;

struct ApplyAgain {
  const BatchWords& words;
  const MapStoreOptions& options;
  MissionState& state;

  void operator()(const BatchRecord& record) { Apply(record, words, options, state); }
  void operator()(const QueryRecord& record) { Apply(record, options, state); }
  void operator()(const FuseRecord& record) { Apply(record, options, state); }
  void operator()(const FuseRefusedRecord& record) { Apply(record, state); }
  void operator()(const AdjustRecord& record) { Apply(record, options, state); }
  void operator()(const RederiveRecord& record) { Apply(record, state); }
  void operator()(const RetractRecord& record) { Apply(record, options, state); }
};

BatchWords WordsOf(const JournalRecord& record, const Vocabulary* vocabulary) {
  const auto* update = std::get_if<BatchRecord>(&record);
  return update == nullptr ? BatchWords() : ComputeWords(*update->batch, vocabulary);
}

void DropFeatures(const JournalRecord& record, MissionState& state) {
  const auto* update = std::get_if<BatchRecord>(&record);
  if (update == nullptr) return;
  LocalMapState& local_map = *state.FindLocalMap(update->batch->local_map);
  for (const FullKeyframe& keyframe : update->batch->full_keyframes) {
    local_map.map.DropFeatures(keyframe.payload->id);
  }
}

// How much there is of a local map: a replay must come to the same.
struct Extent {
  uint64_t last_batch = 0;
  size_t keyframes = 0;
  size_t points = 0;

  bool operator==(const Extent&) const = default;
};

std::map<LocalMapId, Extent> Measure(const MissionState& state) {
  std::map<LocalMapId, Extent> extents;
  for (const auto& [id, local_map] : state.local_maps) {
    extents[id] = {local_map.last_batch, local_map.map.keyframes().size(),
                   local_map.map.points().size()};
  }
  return extents;
}

}  // namespace

absl::Status Mission::Recover() {
  Journal::Replay replay;
  MissionState state;
  state.name = name_;
  replay.on_snapshot = [&](MissionState snapshot) {
    state = std::move(snapshot);
    RestoreWords(environment_.vocabulary, state);
    return absl::OkStatus();
  };
  replay.on_record = [&](const JournalRecord& record) {
    RETURN_IF_ERROR(CheckReplay(record, state));
    const BatchWords words = WordsOf(record, environment_.vocabulary);
    std::visit(ApplyAgain{words, *environment_.options, state}, record);
    return absl::OkStatus();
  };
  ASSIGN_OR_RETURN(appended_, environment_.journal->Recover(name_, replay));
  if (state.name != name_) {
    return absl::DataLossError(
        absl::StrCat("the snapshot of mission ", name_, " is mission ", state.name, "'s"));
  }
  Begin(std::move(state));
  return absl::OkStatus();
}

void Mission::Restore(MissionState state) {
  RestoreWords(environment_.vocabulary, state);
  Begin(std::move(state));
}

void Mission::Begin(MissionState state) {
  state.version = (state.version / kVersionsOfALife + 1) * kVersionsOfALife;
  absl::MutexLock lock(&mutex_);
  state_ = std::move(state);
}

absl::StatusOr<MissionState> Mission::ReplayUntil(Journal::Position position,
                                                  const std::function<bool()>& goes_on) const {
  MissionState state;
  state.name = name_;
  Journal::Replay replay;
  replay.until = position;
  replay.with_features = false;
  replay.on_snapshot = [&](MissionState snapshot) {
    state = std::move(snapshot);
    return absl::OkStatus();
  };
  // Its records were applied once before: they are sound, and words decide nothing any more.
  replay.on_record = [&](const JournalRecord& record) -> absl::Status {
    if (IsDeleted() || !goes_on()) return absl::CancelledError("no snapshot any more");
    const BatchWords none;
    std::visit(ApplyAgain{none, *environment_.options, state}, record);
    DropFeatures(record, state);
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(environment_.journal->Recover(name_, replay).status());
  return state;
}

absl::Status Mission::KeepSnapshot(const std::function<bool()>& goes_on) {
  absl::MutexLock one(&snapshot_mutex_);
  if (!environment_.journal->WantsSnapshot(name_)) return absl::OkStatus();
  Journal::Position position = 0;
  UnrecordedState unrecorded;
  std::map<LocalMapId, Extent> extents;
  {
    // No record comes between the state and its position.
    absl::MutexLock turn(&writer_mutex_);
    position = appended_;
    absl::ReaderMutexLock lock(&mutex_);
    unrecorded = CopyUnrecorded(state_);
    extents = Measure(state_);
  }
  ASSIGN_OR_RETURN(MissionState state, ReplayUntil(position, goes_on));
  if (Measure(state) != extents) {
    return absl::InternalError(absl::StrCat("mission ", name_, " replayed until record ", position,
                                            " is not what it was then"));
  }
  PutUnrecorded(std::move(unrecorded), state);
  JournalSnapshot snapshot = TakeSnapshot(state);
  snapshot.position = position;
  if (IsDeleted()) return absl::CancelledError("no snapshot any more");
  return environment_.journal->WriteSnapshot(name_, snapshot);
}

}  // namespace corbslam::map_store
