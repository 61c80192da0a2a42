// Holds keyframes' pictures on their way to the map store: best effort, behind all that maps need.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_PICTURE_OUTBOX_H_
#define CORBSLAM_CLIENT_AGENT_LINK_PICTURE_OUTBOX_H_

#include <cstddef>
#include <cstdint>
#include <deque>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/upload/link_budget.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// A picture waits until the batch with its keyframe was sent, then until the link has nothing else
// to do. Nothing waits for it, and none is sent twice. Thread-safe.
class PictureOutbox {
 public:
  // Beyond either, the oldest go.
  static constexpr size_t kMaxPictures = 512;
  static constexpr size_t kMaxBytes = 4 << 20;
  // No picture is sent while so many bytes wait in the transport: a batch that comes waits for no
  // more than these and one picture.
  static constexpr uint64_t kMostAhead_bytes = 32 << 10;

  struct Counts {
    size_t waiting = 0;
    uint64_t sent = 0;
    uint64_t sent_bytes = 0;
    uint64_t dropped = 0;
  };

  void Add(KeyframePicture picture) ABSL_LOCKS_EXCLUDED(mutex_);
  // A session stands. `takes`: its store takes pictures; else none are held.
  void BeginSession(bool takes) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns false if the last session's store takes no pictures.
  bool Wants() const ABSL_LOCKS_EXCLUDED(mutex_);
  // The transport has taken the batch: its keyframes' pictures may follow.
  void NoteSent(const MapUpdateBatch& batch) ABSL_LOCKS_EXCLUDED(mutex_);
  // Sends what may be sent, as far as the link has room for it.
  void SendTo(Uplink& uplink, LinkBudget& budget, absl::Time now)
      ABSL_LOCKS_EXCLUDED(sending_, mutex_);

  // Returns whether a picture waits for nothing but the link.
  bool HasReady() const ABSL_LOCKS_EXCLUDED(mutex_);
  Counts counts() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // So many keyframes that were told before their pictures came are remembered.
  static constexpr size_t kMaxTold = 64;

  void DropOldest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Takes the next picture that is ready; false: there is none, or the budget can't spare its
  // bytes.
  bool TakeReady(LinkBudget& budget, absl::Time now, KeyframePicture& picture)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Held while pictures are sent, so that one that is given back is the first again.
  absl::Mutex sending_ ABSL_ACQUIRED_BEFORE(mutex_);
  mutable absl::Mutex mutex_;
  std::deque<KeyframePicture> untold_ ABSL_GUARDED_BY(mutex_);  // Their batches were not sent.
  std::deque<KeyframePicture> ready_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // Of both.
  std::deque<KeyframeId> told_ ABSL_GUARDED_BY(mutex_);
  bool takes_ ABSL_GUARDED_BY(mutex_) = true;
  uint64_t sent_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t sent_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t dropped_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_PICTURE_OUTBOX_H_
