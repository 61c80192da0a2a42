// What the robot may send over a link of so many bytes a second.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_LINK_BUDGET_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_LINK_BUDGET_H_

#include <cstddef>
#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/upload/batch_allowance.h"
#include "slam/util/byte_bucket.h"

namespace corbslam {

// Counts what the transport has really taken, again what it took again after a break; estimates
// only decide what goes into a batch, and are corrected by what batches took. While the budget is
// spent nothing is sent and no batch is made: what changes waits in the map and coalesces there.
// Thread-safe.
class LinkBudget {
 public:
  // 0: no bound, and nothing below ever says no.
  explicit LinkBudget(uint64_t bytes_per_second) : bucket_(bytes_per_second) {}

  bool is_bounded() const;
  // From now on there is no bound: nothing will be sent any more.
  void Lift();

  // So many bytes were written to the wire until now, and so many wait in the transport for it.
  void NoteTransport(uint64_t written, uint64_t waiting, absl::Time now);
  // A batch was taken by the transport, which says how long it really is; 0: it can't.
  void NoteSent(const MapUpdateBatch& batch, uint64_t bytes);

  // As of the last NoteTransport.
  bool MaySend(absl::Time now);
  // Likewise, and the transport has nothing left to write: a link that is slower than its budget is
  // not given more than it takes.
  bool MayTake(absl::Time now);
  // Of a batch that is taken now.
  BatchAllowance Allow(size_t max_keyframes, absl::Time now);

 private:
  mutable absl::Mutex mutex_;
  ByteBucket bucket_ ABSL_GUARDED_BY(mutex_);
  bool lifted_ ABSL_GUARDED_BY(mutex_) = false;
  // Written and waiting, when it was last noted.
  uint64_t accounted_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t waiting_ ABSL_GUARDED_BY(mutex_) = 0;
  double scale_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_LINK_BUDGET_H_
