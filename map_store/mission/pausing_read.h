// Reads much of a mission's state under its lock, with pauses in which writers have their turn.
#ifndef CORBSLAM_MAP_STORE_MISSION_PAUSING_READ_H_
#define CORBSLAM_MAP_STORE_MISSION_PAUSING_READ_H_

#include <functional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/view/long_read.h"

namespace corbslam::map_store {

// Is made, used and given up by one thread under the strand's lock, held for reading.
class PausingRead : public LongRead {
 public:
  // `goes_on` is called after each pause, under the lock; Pause returns its error.
  PausingRead(const MissionStrand& strand, std::function<absl::Status()> goes_on)
      ABSL_SHARED_LOCKS_REQUIRED(strand.mutex())
      : strand_(strand), goes_on_(std::move(goes_on)) {}

  // Lets a writer that waits come first.
  absl::Status Pause() override ABSL_NO_THREAD_SAFETY_ANALYSIS {
    strand_.mutex().ReaderUnlock();
    strand_.gate().Lock();
    strand_.gate().Unlock();
    strand_.mutex().ReaderLock();
    return goes_on_();
  }

 private:
  const MissionStrand& strand_;
  const std::function<absl::Status()> goes_on_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_PAUSING_READ_H_
