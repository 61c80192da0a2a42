// Finds points of the map in a new picture by what they look like in keyframes' pictures.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_PATCH_FOLLOWING_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_PATCH_FOLLOWING_H_

#include <cstddef>
#include <memory>
#include <vector>

#include "absl/types/span.h"
#include "client_agent/tracking/frame.h"
#include "client_agent/tracking/patch_sources.h"
#include "slam/sensor/patch_search.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// A picture that was taken and not searched for features.
struct FreshPicture {
  const Sensor* sensor = nullptr;
  const SensorImages* images = nullptr;
  HalvedPicture picture;  // Of Sensor::Picture.
};

// Makes a frame of the sources that are found where `camera_from_map` has them; `first_level` is
// PatchSearch::first_level, at least. Its keypoints are those found, each with its association, and
// nothing else; their descriptors are those of their keyframes. The pose is `camera_from_map`.
Frame FollowPatches(const FreshPicture& fresh, std::shared_ptr<const Camera> camera,
                    const Rigid3d& camera_from_map, absl::Span<const PatchSource> sources,
                    int first_level);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_PATCH_FOLLOWING_H_
