// Takes what robots send of keyframes' pictures.
#ifndef CORBSLAM_MAP_STORE_MISSION_PICTURE_INTAKE_H_
#define CORBSLAM_MAP_STORE_MISSION_PICTURE_INTAKE_H_

#include <cstdint>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "map_store/mission/mission_strand.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Takes the pictures of all sessions of a mission. Nobody takes the writers' turn for it, and
// nothing is synced. Thread-safe.
class PictureIntake {
 public:
  // The argument is not owned and must outlive it.
  explicit PictureIntake(const MissionStrand& strand) : strand_(strand) {}

  // Does what MapStore::KeepPicture says.
  absl::Status Keep(uint64_t session_id, const std::string& agent, const KeyframePicture& picture);
  // Returns how many bytes of pictures the mission may have: no more than an eighth of what it may
  // take of the disk, so that no map goes without for their sake.
  uint64_t MaxBytes() const;

 private:
  // Returns PERMISSION_DENIED or ABORTED, with the reason. Sets whether the keyframe is there.
  absl::Status Check(uint64_t session_id, const std::string& agent, KeyframeId keyframe,
                     bool& is_there) const ABSL_LOCKS_EXCLUDED(strand_.mutex());

  const MissionStrand& strand_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_PICTURE_INTAKE_H_
