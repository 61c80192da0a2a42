// Says why the map store ended a session for good, in a way that the agent can read.
#ifndef CORBSLAM_SLAM_EXCHANGE_SESSION_END_H_
#define CORBSLAM_SLAM_EXCHANGE_SESSION_END_H_

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace corbslam {

// A status crosses the wire as its code and message alone, and ABORTED has other reasons, too.
inline constexpr char kMissionWasDeleted[] = " was deleted";

// The ABORTED that ends the sessions of a mission that is deleted.
inline absl::Status MissionDeletedError(absl::string_view mission) {
  return absl::AbortedError(absl::StrCat("mission ", mission, kMissionWasDeleted));
}
// Returns whether a session that ended with `reason` ended with its mission.
inline bool SaysMissionDeleted(const absl::Status& reason) {
  return absl::IsAborted(reason) && absl::EndsWith(reason.message(), kMissionWasDeleted);
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_SESSION_END_H_
