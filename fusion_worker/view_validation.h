// Checks whether a view can be computed with. What Map itself keeps (observations stand on both
// sides, the tree has no cycle) needs no check; numbers do.
#ifndef CORBSLAM_FUSION_WORKER_VIEW_VALIDATION_H_
#define CORBSLAM_FUSION_WORKER_VIEW_VALIDATION_H_

#include "absl/status/status.h"
#include "slam/map/map.h"

namespace corbslam::fusion_worker {

// Returns INVALID_ARGUMENT, naming the id, for a keyframe without payload or camera, an impossible
// camera, a rotation that is none, or a value that is not finite.
absl::Status CheckView(const Map& view);

}  // namespace corbslam::fusion_worker

#endif  // CORBSLAM_FUSION_WORKER_VIEW_VALIDATION_H_
