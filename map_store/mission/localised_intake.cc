#include "map_store/mission/localised_intake.h"

#include <glog/logging.h>

#include <cstdint>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/ingest/mission_limits.h"
#include "map_store/ingest/quota.h"
#include "map_store/mission/mission_sessions.h"
#include "map_store/mission/room_check.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::Status LocalisedIntake::Check(uint64_t session_id, const std::string& agent) const {
  RETURN_IF_ERROR(CheckSession(strand_, session_id, agent));
  if (strand_.state().agents.at(agent).localise_only) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat("agent ", agent,
                   " says where it is in the global frame, but opened its session "
                   "without localise_only: its frames belong into batches"));
}

absl::Status LocalisedIntake::NotePlace(uint64_t session_id, const std::string& agent_name,
                                        const LocalisedFrames& localised) {
  StateWriteLock lock(strand_);
  RETURN_IF_ERROR(Check(session_id, agent_name));
  AgentState& agent = strand_.mutable_state().agents.at(agent_name);
  for (const LocalisedFrame& frame : localised.frames) {
    if (frame.camera_from_global.has_value()) {
      agent.localised = frame;
    } else {
      agent.localised_lost_ns = frame.timestamp_ns;
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<LocalisedKept> LocalisedIntake::Last(uint64_t session_id, const std::string& agent,
                                                    uint64_t run) const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  RETURN_IF_ERROR(Check(session_id, agent));
  const LocalisedRun* found = FindRun(strand_.state().agents.at(agent).track, run);
  return LocalisedKept{run, found == nullptr ? 0 : found->last_number};
}

absl::Status LocalisedIntake::CheckLimits(const LocalisedFrames& part) const {
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    RETURN_IF_ERROR(CheckMemoryLimit(strand_.state(), part));
  }
  const uint64_t bytes = StoredBytes(part);
  return CheckRoom(strand_, NameOfPart(part), bytes, bytes);
}

absl::StatusOr<LocalisedKept> LocalisedIntake::Keep(uint64_t session_id, const std::string& agent,
                                                    const LocalisedFrames& part) {
  ASSIGN_OR_RETURN(const LocalisedKept last, Last(session_id, agent, part.run));
  if (part.number != last.number + 1) return last;
  RETURN_IF_ERROR(CheckLimits(part));
  return KeepInTurn(session_id, agent, part);
}

absl::StatusOr<LocalisedKept> LocalisedIntake::KeepInTurn(uint64_t session_id,
                                                          const std::string& agent,
                                                          const LocalisedFrames& part) {
  absl::MutexLock turn(&strand_.turn());
  ASSIGN_OR_RETURN(const LocalisedKept last, Last(session_id, agent, part.run));
  if (part.number != last.number + 1) return last;
  LocalisedRecord record{agent, part, strand_.environment().clock()};
  record.part.frames.clear();
  RETURN_IF_ERROR(strand_.Append(record));
  StateWriteLock lock(strand_);
  map_store::Apply(record, strand_.options(), strand_.mutable_state());
  return LocalisedKept{part.run, part.number};
}

void LocalisedIntake::NoteOutcome(const absl::Status& kept) {
  absl::MutexLock lock(&mutex_);
  if (std::exchange(fails_, !kept.ok()) == !kept.ok()) return;
  if (kept.ok()) {
    LOG(INFO) << "mission " << strand_.name() << " keeps what robots that only localise say again";
  } else {
    LOG(WARNING) << "mission " << strand_.name()
                 << " can't keep what robots that only localise say; they keep it for now: "
                 << kept;
  }
}

absl::StatusOr<std::optional<LocalisedKept>> LocalisedIntake::Note(
    uint64_t session_id, const std::string& agent, const LocalisedFrames& localised) {
  RETURN_IF_ERROR(NotePlace(session_id, agent, localised));
  if (localised.run == 0) return std::nullopt;
  RETURN_IF_ERROR(ValidateLocalised(localised));
  const absl::StatusOr<LocalisedKept> kept = Keep(session_id, agent, localised);
  if (absl::IsAborted(kept.status()) || absl::IsPermissionDenied(kept.status())) {
    return kept.status();
  }
  // A part that came again may not be durable yet.
  const absl::Status durable = kept.ok() ? strand_.Sync() : kept.status();
  // One that leaves a gap is answered, but says nothing of whether there is room.
  if (!durable.ok() || kept->number >= localised.number) NoteOutcome(durable);
  strand_.environment().wake_fusion();
  // The robot goes on to localise without a journal.
  if (!durable.ok()) return std::nullopt;
  return *kept;
}

}  // namespace corbslam::map_store
