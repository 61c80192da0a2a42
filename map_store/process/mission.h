// One mission is its state, who is connected to it, and what is fused of it.
#ifndef CORBSLAM_MAP_STORE_PROCESS_MISSION_H_
#define CORBSLAM_MAP_STORE_PROCESS_MISSION_H_

#include <functional>
#include <string>
#include <utility>

#include "map_store/coordination/fusion_coordinator.h"
#include "map_store/coordination/mission_joining.h"
#include "map_store/coordination/mission_retiring.h"
#include "map_store/mission/batch_intake.h"
#include "map_store/mission/event_book.h"
#include "map_store/mission/localised_intake.h"
#include "map_store/mission/mission_load.h"
#include "map_store/mission/mission_sessions.h"
#include "map_store/mission/mission_snapshots.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/mission/mission_summary.h"
#include "map_store/mission/picture_intake.h"
#include "map_store/mission/picture_localization.h"
#include "map_store/mission/profile_keeper.h"

namespace corbslam::map_store {

// Puts the parts of a mission together; each part's own header says what it does. Thread-safe.
class Mission {
 public:
  Mission(std::string name, MissionEnvironment environment);

  absl::Status Recover() { return strand_.Recover(); }
  void Restore(MissionState state) { strand_.Restore(std::move(state)); }
  // These do what those of MissionStrand do.
  void BeginAs(std::string uid) { strand_.BeginAs(std::move(uid)); }
  void EnsureUid() { strand_.EnsureUid(); }
  absl::Status WriteUid() { return strand_.WriteUid(); }

  MissionSessions& sessions() { return sessions_; }
  BatchIntake& batches() { return batches_; }
  LocalisedIntake& localised() { return localised_; }
  PictureIntake& pictures() { return pictures_; }
  FusionCoordinator& fusion() { return fusion_; }
  const FusionCoordinator& fusion() const { return fusion_; }
  MissionRetiring& retiring() { return retiring_; }
  MissionJoining& joining() { return joining_; }
  MissionSnapshots& snapshots() { return snapshots_; }
  ProfileKeeper& profile() { return profile_; }
  const ProfileKeeper& profile() const { return profile_; }
  Listeners& listeners() { return sessions_.listeners(); }
  EventBook& events() { return events_; }
  const EventBook& events() const { return events_; }

  // Reads the state under its lock; `read` must be quick and must not call back.
  template <typename Read>
  auto WithState(Read read) const {
    return strand_.WithState(std::move(read));
  }
  // Returns what tells it from earlier and later missions of its name.
  std::string uid() const {
    return WithState([](const MissionState& state) { return state.uid; });
  }
  // Does what LocalizePicture does.
  absl::StatusOr<LocalizeAnswer> Localize(FusionWorker& worker, const LocalizeQuery& query,
                                          const std::function<bool()>& goes_on) const {
    return LocalizePicture(strand_, worker, query, goes_on);
  }
  MissionLoad Load() const;
  MissionInfo Info() const;
  // Returns whether somebody listens to its map or its events.
  bool IsWatched() const;
  // Returns whether nothing was ever written of it and nobody watches it: without a session it need
  // not be kept.
  bool IsVacant() const;

  // Returns FAILED_PRECONDITION, with the reason, for a mission that has to stay in memory, whoever
  // uses it: it is watched, fusion has work to do, or only memory has all of it.
  absl::Status CheckMaySleep() const;
  // Ends the use of this object, as the mission goes on on the disk alone, if nothing has changed
  // since `changes` (MissionStrand::changes) and nothing keeps it awake; returns whether. The
  // caller sees to it that nobody uses it.
  bool Retire(uint64_t changes);
  MissionSummary Summarise() const;

  // Ends sessions, and refuses new ones, with this error from here on; OK: no more.
  void RefuseRobots(const absl::Status& why);
  // Does as Delete does, and refuses robots with `why`: another process has the mission.
  void Lose(const absl::Status& why);
  // Does the same, but tells nobody: CallListeners does.
  void Close(const absl::Status& why);
  // Ends everything: sessions are fenced, jobs cancelled, nothing is written any more.
  void Delete();
  // Does so if `may`, which is called while nothing can be written, returns OK; else nothing.
  absl::Status DeleteIf(const std::function<absl::Status()>& may);
  // Calls all who listen: they find out what has become of the mission.
  void CallListeners();

 private:
  absl::Status EndWriting(const std::function<absl::Status()>& may);

  MissionStrand strand_;
  ProfileKeeper profile_;
  EventBook events_;
  MissionSessions sessions_;
  BatchIntake batches_;
  LocalisedIntake localised_;
  PictureIntake pictures_;
  FusionCoordinator fusion_;
  MissionRetiring retiring_;
  MissionJoining joining_;
  MissionSnapshots snapshots_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_MISSION_H_
