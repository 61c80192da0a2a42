// Finds which of many keyframes have come within reach of a robot that moves, without looking at
// all of them each time: a keyframe that is d metres out of reach can't be within before the robot
// has moved d metres.
#ifndef CORBSLAM_MAP_STORE_STATE_FAR_KEYFRAMES_H_
#define CORBSLAM_MAP_STORE_STATE_FAR_KEYFRAMES_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/btree_set.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Keyframes that move are to be added again. Not thread-safe.
class FarKeyframes {
 public:
  // Says where the robot is, in the frame of all calls, in metres.
  void MoveTo(const Eigen::Vector3d& robot);
  // Adds a keyframe that is so far out of the robot's reach now, at least 0 m; one that is here
  // already gets the new distance.
  void Add(KeyframeId id, double out_of_reach_m);
  void Erase(KeyframeId id);
  // Takes out the keyframes that may be within reach now, in no order that matters.
  std::vector<KeyframeId> TakeDue();
  // Takes out all keyframes, by id.
  std::vector<KeyframeId> TakeAll();
  size_t size() const { return due_at_m_.size(); }

 private:
  std::optional<Eigen::Vector3d> robot_;
  double travelled_m_ = 0;
  // How far the robot will have travelled when the keyframe is to be looked at again.
  absl::btree_map<KeyframeId, double> due_at_m_;
  absl::btree_set<std::pair<double, KeyframeId>> by_due_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_FAR_KEYFRAMES_H_
