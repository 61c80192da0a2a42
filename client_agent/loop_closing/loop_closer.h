// Finds places that the robot (or another, by what it shared) has been at before, corrects the
// robot's own map by them, and adjusts all of it afterwards.
#ifndef CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_LOOP_CLOSER_H_
#define CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_LOOP_CLOSER_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/btree_set.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/loop_closing/map_correction.h"
#include "client_agent/map/guarded_map.h"
#include "client_agent/map/own_correction.h"
#include "client_agent/mapping/mapping_queue.h"
#include "slam/exchange/overlap.h"
#include "slam/map/map.h"
#include "slam/verification/place_verification.h"

namespace corbslam::client_agent {

struct LoopCloserOptions {
  // What changes results.
  bool fix_scale = true;  // True: the robot's maps are metric.
  uint64_t seed = 1;
  // Own keyframes nearer than this in number are no loop; nor is one so soon after the last.
  uint32_t min_keyframe_gap = 10;
  // So many of the best candidates are verified.
  size_t max_candidates = 3;
  // So many further keyframes must agree.
  int min_consistent_keyframes = 3;
  int adjustment_iterations = 10;  // Iterations of each round.
  // What changes speed.
  int solver_threads = 1;
  size_t max_waiting_keyframes = 32;
};

struct LoopCloserCounts {
  int queried = 0;
  int verified = 0;
  int closed = 0;
  int closed_against_others = 0;  // The part of `closed` whose candidate is another local map's.
  int adjusted = 0;               // Full bundle adjustments that were applied.
};

// Returns keyframes of the robot's map (own and shared ones) that look like the query, best first
// and one a group of covisible ones; none of `excluded`. It is called without any lock of the
// LoopCloser or the map held, with a keyframe that carries its words; thread-safe.
using FindLoopCandidates = std::function<std::vector<KeyframeId>(
    const Keyframe& query, const absl::btree_set<KeyframeId>& excluded)>;

// Takes along what others made after the own map was corrected. It is called on the mapping thread,
// outside of Read and Write: it plans while others read.
using FollowCorrection = std::function<void(const OwnCorrection& correction, GuardedMap& map)>;

// Closes loops in one local map. Two workers drive it: one calls StepDetection, the other
// StepAdjustment (the same thread may do both, as deterministic runs do). Only jobs that it posts
// to the mapping queue change the map, and each worker has one posted at a time. The rest is
// thread-safe.
class LoopCloser {
 public:
  // The map and the queue are not owned; both outlive the closer and the jobs that it posted.
  // `follow` may be null.
  LoopCloser(const LoopCloserOptions& options, GuardedMap* map, MappingQueue* queue,
             FindLoopCandidates find_candidates, FollowCorrection follow = nullptr);
  // The workers must have ended, and the queue must have run or dropped the closer's jobs.
  ~LoopCloser() = default;

  // Takes a keyframe that the mapper is done with. When too many wait, the oldest is forgotten.
  void Enqueue(KeyframeId keyframe);

  // Looks for a loop at the next waiting keyframe, and posts the correction where there is one.
  // Returns false when there was nothing to do: no keyframe waits, or the last correction is not in
  // yet.
  bool StepDetection();
  // Adjusts the whole map when a loop was closed since the last time, and posts the result. A newer
  // loop cancels it (and calls for another). Returns false when there was nothing to do.
  bool StepAdjustment();

  // Block until there is something to do and return true, or until Stop is called and return false.
  bool WaitForDetection();
  bool WaitForAdjustment();
  // Ends waiting, and cancels an adjustment under way.
  void Stop();

  // True when nothing waits and nothing is under way, neither in a worker nor in a posted job.
  bool IsIdle() const;
  // Returns true when it is idle, and false at the deadline.
  bool WaitUntilIdle(absl::Time deadline) const;

  LoopCloserCounts counts() const;

 private:
  std::optional<Overlap> DetectLoop(KeyframeId query);
  bool CloseLoop(const Overlap& loop);
  // Runs in a job on the mapping thread.
  void Apply(const MapCorrection& correction);
  bool Idle() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  bool DetectionIsReady() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  bool AdjustmentIsReady() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);

  const LoopCloserOptions options_;
  GuardedMap& map_;
  MappingQueue& queue_;
  const FindLoopCandidates find_candidates_;
  const FollowCorrection follow_;
  // Counts closed loops; an adjustment that began at a lower one is out of date.
  std::atomic<uint64_t> generation_ = 0;
  std::atomic<bool> stopping_ = false;

  mutable absl::Mutex mutex_;
  std::deque<KeyframeId> waiting_ ABSL_GUARDED_BY(mutex_);
  std::optional<KeyframeId> last_closed_at_ ABSL_GUARDED_BY(mutex_);
  bool detecting_ ABSL_GUARDED_BY(mutex_) = false;
  bool correction_posted_ ABSL_GUARDED_BY(mutex_) = false;
  bool adjusting_ ABSL_GUARDED_BY(mutex_) = false;
  bool adjustment_wanted_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  LoopCloserCounts counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_LOOP_CLOSER_H_
