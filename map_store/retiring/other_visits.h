// Says which keyframes of other local maps look at what one looks at, in whatever light.
#ifndef CORBSLAM_MAP_STORE_RETIRING_OTHER_VISITS_H_
#define CORBSLAM_MAP_STORE_RETIRING_OTHER_VISITS_H_

#include <cstddef>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "map_store/retiring/retiring_view.h"

namespace corbslam::map_store {

struct OtherVisitsOptions {
  // Keyframes look at the same place when one stands no further from the other than this share of
  // the median distance of the landmarks that the other observes, so that units don't matter, and
  // their optical axes are within so many degrees (by their cosine: 20) of each other.
  double near_share = 0.25;
  double min_axis_cosine = 0.94;
  // A keyframe that observes fewer landmarks has no distance to go by, and no other visits.
  size_t min_landmarks = 5;
};

// The keyframes of closed local maps other than its own that look at the place of each candidate.
using OtherVisits = absl::flat_hash_map<KeyframeId, std::vector<KeyframeId>>;

// Goes by poses alone: what doesn't look alike, by night and by day, is a visit of the same place,
// too. Candidates without other visits are not in it. Pure.
OtherVisits FindOtherVisits(const RetiringView& view, const OtherVisitsOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_OTHER_VISITS_H_
