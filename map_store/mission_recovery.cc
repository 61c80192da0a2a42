// Mission and its journal: what it reads at its start, and its snapshots.
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "map_store/durable/state_archive.h"
#include "map_store/mission.h"
#include "map_store/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Above all versions that watchers may have seen before.
constexpr uint64_t kVersionsOfALife = uint64_t{1} << 40;

absl::Status ApplyAgain(const JournalRecord& record, const Vocabulary* vocabulary,
                        const MapStoreOptions& options, MissionState& state) {
  RETURN_IF_ERROR(CheckReplay(record, state));
  if (const auto* batch = std::get_if<BatchRecord>(&record)) {
    Apply(*batch, ComputeWords(*batch->batch, vocabulary), options, state);
  } else if (const auto* query = std::get_if<QueryRecord>(&record)) {
    Apply(*query, options, state);
  } else if (const auto* fuse = std::get_if<FuseRecord>(&record)) {
    Apply(*fuse, options, state);
  } else if (const auto* refused = std::get_if<FuseRefusedRecord>(&record)) {
    Apply(*refused, state);
  } else if (const auto* adjust = std::get_if<AdjustRecord>(&record)) {
    Apply(*adjust, options, state);
  } else {
    Apply(std::get<RederiveRecord>(record), state);
  }
  return absl::OkStatus();
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
    return ApplyAgain(record, environment_.vocabulary, *environment_.options, state);
  };
  RETURN_IF_ERROR(environment_.journal->Recover(name_, replay));
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

absl::Status Mission::KeepSnapshot() {
  if (!environment_.journal->WantsSnapshot(name_)) return absl::OkStatus();
  JournalSnapshot snapshot;
  {
    // No record comes between the state and its position.
    absl::MutexLock turn(&writer_mutex_);
    snapshot = WithState(&TakeSnapshot);
    snapshot.position = appended_;
  }
  return environment_.journal->WriteSnapshot(name_, snapshot);
}

}  // namespace corbslam::map_store
