// Keeps what people set of one mission, and when it was used.
#ifndef CORBSLAM_MAP_STORE_MISSION_PROFILE_KEEPER_H_
#define CORBSLAM_MAP_STORE_MISSION_PROFILE_KEEPER_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/state/mission_profile.h"
#include "slam/util/byte_bucket.h"

namespace corbslam::map_store {

// Changes the profile in the journal and in the state. Thread-safe.
class ProfileKeeper {
 public:
  // Uses that no batch says are written down no more often. After a restart a mission may have been
  // used so much later than is known.
  static constexpr absl::Duration kBetweenUses = absl::Hours(1);

  // `strand` is not owned and must outlive it.
  explicit ProfileKeeper(MissionStrand& strand) : strand_(strand) {}

  // Makes the mission, of which nothing was written, with what is set in `profile`. It is durable
  // when the function returns OK. INVALID_ARGUMENT: ValidateProfile.
  absl::Status Begin(MissionProfile profile);
  // Changes these fields to those of `values`; the same holds. NOT_FOUND once it is deleted;
  // ABORTED if `expected_revision` is given and is not the profile's.
  absl::Status Update(const MissionProfile& values, const std::vector<ProfileField>& fields,
                      std::optional<uint64_t> expected_revision = std::nullopt);
  // Does PutSettings; the same holds.
  absl::Status SetRobotSettings(const std::string& agent, const SignedSettings& settings);
  // Returns those that hold for an agent, those of all robots first, unless they are those that
  // `told` has the versions of, which follow; there may be none.
  std::vector<SignedSettings> NewerSettings(const std::string& agent, SettingsVersions& told) const;

  // Notes that somebody uses the mission now.
  void NoteUse() { used_ns_ = ToProfileTime(strand_.environment().clock()); }
  // Writes down when the mission was used last, if that is due.
  absl::Status KeepUse();
  // Returns the profile as it is now.
  MissionProfile Get() const;
  // Returns whether the mission's retention has passed since it was used last; never by a clock
  // that stands before that.
  bool IsOutdated() const;

  // Counts bytes of batches that an agent has sent. Returns how long it has to wait before more is
  // read of it.
  absl::Duration PaceUplink(const std::string& agent, uint64_t bytes) ABSL_LOCKS_EXCLUDED(pacing_);

 private:
  // What an agent may send of, and at which rate that was made.
  struct Pace {
    uint64_t bytes_per_second = 0;
    ByteBucket bucket{0};
  };

  // Changes the profile by `change`, which may return an error instead.
  absl::Status Change(const std::function<absl::Status(MissionProfile&)>& change);
  absl::Status Write(const MissionProfile& profile) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  int64_t LastUse(const MissionProfile& recorded) const;

  MissionStrand& strand_;
  // When it was used last, since the process began; 0: not yet.
  std::atomic<int64_t> used_ns_ = 0;
  absl::Mutex pacing_;
  std::map<std::string, Pace> paces_ ABSL_GUARDED_BY(pacing_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_PROFILE_KEEPER_H_
