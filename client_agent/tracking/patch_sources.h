// What a new picture may be held against: patches of own keyframes' pictures.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_PATCH_SOURCES_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_PATCH_SOURCES_H_

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <vector>

#include "client_agent/tracking/frame.h"
#include "client_agent/tracking/local_map_view.h"
#include "slam/map/map.h"
#include "slam/sensor/halved_picture.h"

namespace corbslam::client_agent {

// The pictures of the newest own keyframes. Patches always come from these, never from the frame
// before, so that what is followed does not drift.
class KeyframePictures {
 public:
  static constexpr size_t kMost = 16;

  // The pixels are copied.
  void Add(KeyframeId id, const HalvedPicture& picture);
  // Null where there is none.
  const HalvedPicture* Find(KeyframeId id) const;

 private:
  std::map<KeyframeId, HalvedPicture> pictures_;
};

// A point in view, and the newest own keyframe with a picture that sees it.
struct PatchSource {
  MapPointId point;
  Eigen::Vector3d position_in_map;
  int octave = 0;  // On which it should appear now.
  const HalvedPicture* picture = nullptr;
  Rigid3d source_from_map;
  Keypoint keypoint;
  Descriptor descriptor;
};

// Returns the sources of those of the points that have one: first one of each part of the picture,
// then a second one, and so on, `most` of them.
std::vector<PatchSource> FindPatchSources(const Map& map, LocalMapId own,
                                          const std::vector<PointInView>& points,
                                          const Camera& camera, const KeyframePictures& pictures,
                                          size_t most);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_PATCH_SOURCES_H_
