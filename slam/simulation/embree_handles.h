// Embree's reference-counted handles as unique pointers.
#ifndef CORBSLAM_SLAM_SIMULATION_EMBREE_HANDLES_H_
#define CORBSLAM_SLAM_SIMULATION_EMBREE_HANDLES_H_

#include <embree3/rtcore.h>

#include <memory>
#include <type_traits>

namespace corbslam {

struct ReleaseEmbree {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};

using EmbreeDevice = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseEmbree>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseEmbree>;
using EmbreeGeometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, ReleaseEmbree>;

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_EMBREE_HANDLES_H_
