// Says which keyframes see a landmark, whether or not anybody has noted it, and which should and do
// not.
#ifndef CORBSLAM_MAP_STORE_RETIRING_LANDMARK_SIGHTS_H_
#define CORBSLAM_MAP_STORE_RETIRING_LANDMARK_SIGHTS_H_

#include <map>
#include <vector>

#include "absl/container/btree_map.h"
#include "map_store/retiring/retiring_view.h"

namespace corbslam::map_store {

struct LandmarkSights {
  // A keyframe that observes the landmark, or has a keypoint that looks like it where it should be,
  // and the keypoint's level.
  struct Seen {
    KeyframeId keyframe;
    int octave = 0;
    bool observed = false;
  };
  std::vector<Seen> seen;             // By keyframe.
  std::vector<KeyframeId> missed_by;  // Those which should see it and don't, by id.
};

struct SightOptions {
  // The landmark should be so far inside the picture, as a share of its width.
  double margin_share = 0.04;
  // It should be seen from within so many degrees (by their cosine) of the mean direction from
  // which it was.
  double min_view_cosine = 0.8;
  // A keypoint so near to where the landmark should be, in pixels of its level, may be of it.
  double radius_px = 4;
  // Hamming distances up to which a keypoint is of the landmark, and from which on it is not: what
  // lies between is no evidence of either.
  int max_distance = 50;
  int min_other_distance = 80;
  // Where something is seen so near to it (radians) at less than this share of its distance, the
  // landmark may be hidden; where nothing is seen within `lit_rad`, the picture may be dark.
  double hiding_rad = 0.02;
  double hiding_share = 0.9;
  double lit_rad = 0.15;
};

using SightsOfLandmarks = absl::btree_map<MapPointId, LandmarkSights>;

// Judges all landmarks of the view by all its keyframes of closed local maps. Pure.
SightsOfLandmarks FindSights(const RetiringView& view, const SightOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_LANDMARK_SIGHTS_H_
