// Holds what a robot says that changes nothing, until it is sent, and its trajectory until that is
// kept.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_LOCALISED_OUTBOX_H_
#define CORBSLAM_CLIENT_AGENT_LINK_LOCALISED_OUTBOX_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/link/backoff.h"
#include "client_agent/upload/link_budget.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// Parts of the trajectory go up numbered, and again until the store has answered that they are
// kept. To a store that keeps none (Capabilities::keeps_localised) only places go. Thread-safe.
class LocalisedOutbox {
 public:
  // So many places wait to be sent; when there are more, the oldest are dropped.
  static constexpr size_t kMaxPlaces = 5000;
  // A part has at most so many frames. So many parts at most wait for their answer.
  static constexpr size_t kMaxFramesOfAPart = 5000;
  static constexpr size_t kMaxParts = 16;
  // A part without an answer goes again after so long at most, counted from when the transport has
  // sent all. Each time after that it takes twice as long, up to the longest, until an answer says
  // that more is kept.
  static constexpr absl::Duration kPatience = absl::Seconds(10);
  static constexpr absl::Duration kLongestPatience = absl::Seconds(160);

  // At most about `max_bytes` of the trajectory are held; then the oldest frames that no part has
  // go, and a gap is told in their place. `seed` draws the run's number and the patience's jitter.
  LocalisedOutbox(size_t max_bytes, uint64_t seed, std::optional<RecordedCamera> recorded_camera);

  void AddPlace(const LocalisedFrame& place) ABSL_LOCKS_EXCLUDED(mutex_);
  // The frame is of a camera that was tracked in others' keyframes; without a reference, or with a
  // pose that a store refuses, it is as one that was lost.
  void AddTracked(const TrackedFrame& frame) ABSL_LOCKS_EXCLUDED(mutex_);
  void AddLost(int64_t timestamp_ns) ABSL_LOCKS_EXCLUDED(mutex_);

  // A session stands: parts without an answer go again. `keeps`: the store keeps trajectories.
  void BeginSession(bool keeps) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteKept(const LocalisedKept& kept) ABSL_LOCKS_EXCLUDED(mutex_);
  // What has no answer goes again as soon as if it were the first time.
  void ResetPatience() ABSL_LOCKS_EXCLUDED(mutex_);
  // Sends what there is, if the last was sent that long ago, as far as the budget has paid for it.
  // What a bounded budget leaves waits: frames for a part that it allows, places for the newest.
  void SendTo(Uplink& uplink, LinkBudget& budget, absl::Duration interval, absl::Time now)
      ABSL_LOCKS_EXCLUDED(sending_, mutex_);

  // Returns how many frames of the trajectory the store has not answered for; 0 if it keeps none.
  size_t CountUnkept() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns how many went because there was no room.
  uint64_t dropped() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Without a pose: lost.
  struct Frame {
    TrackedFrame tracked;
    bool is_lost = false;
  };

  void Add(const Frame& frame) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Numbers all parts anew, in another run.
  void BeginRun() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void MakePart(BatchAllowance allowance) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::vector<LocalisedFrame> TakePlaces(bool newest_only) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Sends all parts again where their answer is waited for too long.
  void CheckPatience(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns the next message; nullopt: there is nothing to send. `is_under_way`: the transport has
  // not sent all yet.
  std::optional<LocalisedFrames> Next(LinkBudget& budget, absl::Time now, bool is_under_way)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Takes back what was not sent.
  void TakeBack(LocalisedFrames unsent) ABSL_LOCKS_EXCLUDED(mutex_);

  const size_t max_frames_;
  const std::optional<RecordedCamera> recorded_camera_;

  // Held while messages are sent, so that parts go in their order.
  absl::Mutex sending_ ABSL_ACQUIRED_BEFORE(mutex_);
  absl::Time last_ ABSL_GUARDED_BY(sending_) = absl::InfinitePast();
  mutable absl::Mutex mutex_;
  uint64_t run_ ABSL_GUARDED_BY(mutex_);
  std::optional<bool> keeps_ ABSL_GUARDED_BY(mutex_);  // Nullopt before the first session.
  std::deque<LocalisedFrame> places_ ABSL_GUARDED_BY(mutex_);
  std::deque<Frame> frames_ ABSL_GUARDED_BY(mutex_);  // That no part has.
  // Parts without an answer, by number; the first `sent_` are sent.
  std::deque<LocalisedFrames> parts_ ABSL_GUARDED_BY(mutex_);
  size_t sent_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t last_number_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t dropped_ ABSL_GUARDED_BY(mutex_) = 0;
  bool says_dropped_ ABSL_GUARDED_BY(mutex_) = false;
  // Since when an answer is waited for.
  std::optional<absl::Time> waits_since_ ABSL_GUARDED_BY(mutex_);
  Backoff backoff_ ABSL_GUARDED_BY(mutex_);
  absl::Duration patience_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_LOCALISED_OUTBOX_H_
