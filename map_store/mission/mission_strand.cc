#include "map_store/mission/mission_strand.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <variant>

#include "absl/strings/str_cat.h"
#include "map_store/records/record_application.h"
#include "map_store/state/mission_uid.h"
#include "slam/exchange/session_end.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Versions grow by so much with each start of the process, above all that watchers may have seen
// before.
constexpr uint64_t kVersionsOfALife = uint64_t{1} << 40;

struct ApplyAgain {
  const BatchWords& words;
  const MapStoreOptions& options;
  MissionState& state;

  void operator()(const BatchRecord& record) { Apply(record, words, options, state); }
  void operator()(const QueryRecord& record) { Apply(record, options, state); }
  void operator()(const FuseRecord& record) {
    RevisionLayers layers = TakeLayers(record.plan, options, state);
    Apply(record, layers, state);
  }
  void operator()(const FuseRefusedRecord& record) { Apply(record, state); }
  void operator()(const AdjustRecord& record) {
    RevisionLayers layers = TakeLayers(record.plan, options, state);
    Apply(record, layers, state);
  }
  void operator()(const RederiveRecord& record) { Apply(record, state); }
  void operator()(const RetractRecord& record) { Apply(record, options, state); }
  void operator()(const ProfileRecord& record) { Apply(record, state); }
  void operator()(const RetireRecord& record) { Apply(record, state); }
  void operator()(const JoinRecord& record) { Apply(record, state); }
  void operator()(const ForgetRecord& record) { Apply(record, state); }
  void operator()(const UidRecord& record) { Apply(record, state); }
  void operator()(const LocalisedRecord& record) { Apply(record, options, state); }
};

BatchWords BatchWordsOf(const JournalRecord& record, const Vocabulary* vocabulary) {
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

}  // namespace

MissionStrand::MissionStrand(std::string name, MissionEnvironment environment)
    : name_(std::move(name)), environment_(std::move(environment)) {
  state_.name = name_;
}

absl::Status MissionStrand::Recover() {
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
    const BatchWords words = BatchWordsOf(record, environment_.vocabulary);
    std::visit(ApplyAgain{words, options(), state}, record);
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

void MissionStrand::Restore(MissionState state) {
  RestoreWords(environment_.vocabulary, state);
  Begin(std::move(state));
}

void MissionStrand::BeginAs(std::string uid) {
  uid_is_recorded_ = false;
  absl::MutexLock lock(&mutex_);
  state_.uid = std::move(uid);
}

absl::Status MissionStrand::PromiseUid() {
  if (uid_is_recorded_ || environment_.promise_uid == nullptr) return absl::OkStatus();
  return environment_.promise_uid(
      {name_, WithState([](const MissionState& state) { return state.uid; })});
}

void MissionStrand::EnsureUid() {
  absl::MutexLock turn(&turn_);
  if (!state_in_turn().uid.empty()) return;
  {
    absl::MutexLock lock(&mutex_);
    state_.uid = DrawMissionUid(name_);
  }
  uid_is_recorded_ = false;
  RecordUid();
}

absl::Status MissionStrand::WriteUid() {
  {
    absl::MutexLock turn(&turn_);
    RETURN_IF_ERROR(Append(UidRecord{state_in_turn().uid}));
    uid_is_recorded_ = true;
    if (environment_.note_uid != nullptr) environment_.note_uid(name_, state_in_turn().uid);
  }
  return Sync();
}

void MissionStrand::RecordUid() {
  const UidRecord record{state_in_turn().uid};
  const absl::StatusOr<Journal::Position> appended = environment_.journal->Append(name_, record);
  if (!appended.ok()) {
    LOG(WARNING) << "the uid of mission " << name_
                 << " is written with its next record: " << appended.status();
    return;
  }
  appended_ = *appended;
  uid_is_recorded_ = true;
  if (environment_.note_uid != nullptr) environment_.note_uid(name_, record.uid);
}

void MissionStrand::Begin(MissionState state) {
  state.version = (state.version / kVersionsOfALife + 1) * kVersionsOfALife;
  absl::MutexLock lock(&mutex_);
  state_ = std::move(state);
}

absl::StatusOr<MissionState> MissionStrand::ReplayUntil(Journal::Position& position,
                                                        const std::function<bool()>& goes_on,
                                                        const StateVisitor& visit) const {
  if (IsDeleted()) return absl::CancelledError("nobody waits for the replay");
  MissionState state;
  state.name = name_;
  Journal::Replay replay;
  replay.until = position;
  replay.with_features = false;
  const auto show = [&] { return visit == nullptr ? absl::OkStatus() : visit(state); };
  replay.on_snapshot = [&](MissionState snapshot) {
    state = std::move(snapshot);
    return show();
  };
  // The records were applied once before: they are sound, and words decide nothing any more.
  replay.on_record = [&](const JournalRecord& record) -> absl::Status {
    if (IsDeleted() || !goes_on()) return absl::CancelledError("nobody waits for the replay");
    const BatchWords none;
    std::visit(ApplyAgain{none, options(), state}, record);
    DropFeatures(record, state);
    return show();
  };
  ASSIGN_OR_RETURN(position, environment_.journal->Recover(name_, replay));
  return state;
}

void MissionStrand::MarkDeleted() {
  absl::MutexLock lock(&mutex_);
  deleted_ = true;
}

bool MissionStrand::IsDeleted() const {
  absl::ReaderMutexLock lock(&mutex_);
  return deleted_;
}

absl::Status MissionStrand::Deleted() const {
  if (!refusal_.ok()) return refusal_;
  return absl::NotFoundError(absl::StrCat("mission ", name_, " is deleted"));
}

absl::Status MissionStrand::SayDeleted() const {
  absl::ReaderMutexLock lock(&mutex_);
  return Deleted();
}

absl::Status MissionStrand::SessionEnd() const {
  return refusal_.ok() ? MissionDeletedError(name_) : refusal_;
}

void MissionStrand::Refuse(const absl::Status& why) {
  absl::MutexLock lock(&mutex_);
  refusal_ = why;
}

absl::Status MissionStrand::CheckNotDeleted() const {
  absl::ReaderMutexLock lock(&mutex_);
  return deleted_ ? SessionEnd() : absl::OkStatus();
}

absl::Status MissionStrand::Append(const JournalRecord& record) {
  RETURN_IF_ERROR(CheckNotDeleted());
  ASSIGN_OR_RETURN(appended_, environment_.journal->Append(name_, record));
  if (!uid_is_recorded_) RecordUid();
  return absl::OkStatus();
}

MissionStrand::WriteTimes MissionStrand::write_times() const {
  return {absl::Nanoseconds(written_ns_.load()), absl::Nanoseconds(longest_write_ns_.load())};
}

absl::Status MissionStrand::Sync() {
  RETURN_IF_ERROR(CheckNotDeleted());
  const absl::Status synced = environment_.journal->Sync(name_, appended_);
  // A deletion closes the journal under whoever syncs.
  if (!synced.ok()) RETURN_IF_ERROR(CheckNotDeleted());
  return synced;
}

StateWriteLock::StateWriteLock(MissionStrand& strand) : strand_(strand) {
  strand_.gate().Lock();
  strand_.mutex().Lock();
  strand_.gate().Unlock();
  begin_ = std::chrono::steady_clock::now();
}

StateWriteLock::~StateWriteLock() {
  const std::chrono::nanoseconds held = std::chrono::steady_clock::now() - begin_;
  const int64_t held_ns = held.count();
  strand_.written_ns_ += held_ns;
  strand_.longest_write_ns_ = std::max(strand_.longest_write_ns_.load(), held_ns);
  strand_.mutex().Unlock();
}

}  // namespace corbslam::map_store
