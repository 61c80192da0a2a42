// Holds work for the mapping thread, the one writer of the robot's map: new keyframes from
// tracking, and jobs of those who want the map changed.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_MAPPING_QUEUE_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_MAPPING_QUEUE_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/map/guarded_map.h"
#include "slam/map/keyframe.h"

namespace corbslam::client_agent {

// A point that two keyframes see and that parallax located.
struct FoundPoint {
  uint32_t in_first = 0;  // Keypoints.
  uint32_t in_second = 0;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
};

// What the map of one camera begins with beside its second keyframe. The map's frame is the first
// one's.
struct MapBeginning {
  std::shared_ptr<const KeyframePayload> first;
  std::shared_ptr<const Words> words;  // Of the first.
  std::vector<FoundPoint> points;
};

// A frame that tracking chose to keep.
struct NewKeyframe {
  std::shared_ptr<const KeyframePayload> payload;
  std::shared_ptr<const Words> words;
  // The keyframe that it was tracked against; invalid for the first keyframe of its local map.
  KeyframeId reference;
  // For the first keyframe this is camera_from_map. The reference may move until the keyframe is
  // inserted.
  Rigid3d camera_from_reference;
  // The map points that tracking found, one entry a keypoint. Some may be gone meanwhile.
  std::vector<MapPointId> points;
  // Only of the second keyframe of a map without depths. Both come into the map together.
  std::shared_ptr<const MapBeginning> beginning;
};

using MappingJob = std::function<void(GuardedMap&)>;

// Thread-safe, for any number of producers and one consumer. Its producers bound it: tracking asks
// HasRoom before it makes a keyframe, and each job's poster has one job under way at most.
class MappingQueue {
 public:
  explicit MappingQueue(size_t max_keyframes = 3) : max_keyframes_(max_keyframes) {}

  bool HasRoom() const;
  // Returns false, and queues nothing, when there is no room.
  bool PushKeyframe(NewKeyframe keyframe);
  // Runs the job on the mapping thread, after those posted before. A keyframe that waits meanwhile
  // may come first.
  void PostJob(MappingJob job);

  // True when nothing waits and the consumer is not at work.
  bool IsIdle() const;
  // Number of keyframes that wait.
  size_t keyframes() const;

  // Return the next item, or none. After an item the consumer counts as at work until it calls
  // Done.
  std::optional<NewKeyframe> TryPopKeyframe();
  std::optional<MappingJob> TryPopJob();
  void Done();
  // Returns true when something waits or the consumer has not called Done, and false when Stop was
  // called.
  bool WaitForWork();
  // Returns true when the queue is idle (or stopped), and false at the deadline.
  bool WaitUntilIdle(absl::Time deadline);
  // Wakes everybody; items that wait are dropped.
  void Stop();

 private:
  template <typename Item>
  std::optional<Item> TryPop(std::deque<Item>& items) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool Idle() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return !busy_ && jobs_.empty() && keyframes_.empty();
  }

  const size_t max_keyframes_;
  mutable absl::Mutex mutex_;
  std::deque<NewKeyframe> keyframes_ ABSL_GUARDED_BY(mutex_);
  std::deque<MappingJob> jobs_ ABSL_GUARDED_BY(mutex_);
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_MAPPING_QUEUE_H_
