// Finds landmarks that were there and are there no more.
#ifndef CORBSLAM_MAP_STORE_RETIRING_FADING_H_
#define CORBSLAM_MAP_STORE_RETIRING_FADING_H_

#include <cstddef>
#include <vector>

#include "map_store/retiring/landmark_sights.h"
#include "map_store/retiring/retiring_view.h"

namespace corbslam::map_store {

struct FadingOptions {
  // So many keyframes, of so many local maps that came after the last one that saw the landmark,
  // should have seen it and didn't.
  size_t min_missed = 5;
  size_t min_local_maps = 2;
  // The probability that all of them would miss it if it were there. A keyframe sees what is there
  // as often as the landmark was seen while it was, times how much the keyframe sees of what the
  // landmark's own local map saw.
  double max_chance = 0.01;
  // A keyframe that sees less of that than this says nothing: it may stand elsewhere, or everything
  // may look different (night).
  double min_agreement = 0.25;
  size_t min_agreeing = 10;
};

// Returns the survivors of landmarks that have vanished, ascending. A landmark that somebody sees
// who is not of a closed local map, or of which a member is not, never has. Pure.
std::vector<MapPointId> FindFaded(const RetiringView& view, const SightsOfLandmarks& sights,
                                  const FadingOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_FADING_H_
