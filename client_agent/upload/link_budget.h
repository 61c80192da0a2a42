// Bounds what the robot may send over a link of so many bytes a second.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_LINK_BUDGET_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_LINK_BUDGET_H_

#include <cstddef>
#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/upload/batch_allowance.h"
#include "slam/exchange/uplink.h"
#include "slam/util/byte_bucket.h"

namespace corbslam::client_agent {

// Counts what the transport has really taken, including what it took a second time after a break;
// estimates only decide what goes into a batch, and are corrected by what batches took. While the
// budget is spent nothing is sent and no batch is made: what changes waits in the map and coalesces
// there. Thread-safe.
class LinkBudget {
 public:
  // With 0 there is no bound, and nothing below ever says no.
  explicit LinkBudget(uint64_t bytes_per_second)
      : bytes_per_second_(bytes_per_second), bucket_(bytes_per_second) {}

  bool is_bounded() const;
  // Sets another rate, or 0; what was spent of the one before counts no more.
  void SetRate(uint64_t bytes_per_second);
  uint64_t bytes_per_second() const;
  // Lifts the bound for good, for when nothing will be sent any more.
  void Lift();

  // Notes what the transport has taken until now.
  void NoteTransport(const Uplink& uplink, absl::Time now);
  // Notes how many bytes were written to the wire until now, and how many wait in the transport for
  // it.
  void NoteTransport(uint64_t written, uint64_t waiting, absl::Time now);
  // Notes that the transport took a batch of so many bytes; 0: the transport can't tell its length.
  void NoteSent(const MapUpdateBatch& batch, uint64_t bytes);

  // Returns whether a batch may be sent, as of the last NoteTransport.
  bool MaySend(absl::Time now);
  // Returns whether a batch may be made: it may be sent, and the transport has nothing left to
  // write, so that a link that is slower than its budget is not given more than it takes.
  bool MayTake(absl::Time now);
  // Returns whether so many bytes may be sent of what maps can do without: after them half of what
  // the budget holds at most is still there.
  bool CanSpare(uint64_t bytes, absl::Time now);
  // Returns the allowance of a batch that is made now.
  BatchAllowance Allow(size_t max_keyframes, absl::Time now);

 private:
  mutable absl::Mutex mutex_;
  uint64_t bytes_per_second_ ABSL_GUARDED_BY(mutex_);
  ByteBucket bucket_ ABSL_GUARDED_BY(mutex_);
  bool lifted_ ABSL_GUARDED_BY(mutex_) = false;
  // Bytes that were written or waiting when the transport was last noted.
  uint64_t accounted_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t waiting_ ABSL_GUARDED_BY(mutex_) = 0;
  double scale_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_LINK_BUDGET_H_
