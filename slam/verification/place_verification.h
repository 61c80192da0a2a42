// Decides whether two keyframes show the same place, and how they stand to each other. It is the
// chain of tests of ORB-SLAM2/3 (Campos et al., T-RO 2021, section VI.B), each of which may refuse.
#ifndef CORBSLAM_SLAM_VERIFICATION_PLACE_VERIFICATION_H_
#define CORBSLAM_SLAM_VERIFICATION_PLACE_VERIFICATION_H_

#include <cstdint>

#include "slam/exchange/overlap.h"
#include "slam/map/map.h"

namespace corbslam {

struct PlaceVerificationOptions {
  // True: the scale is held at 1 (both sides are metric).
  bool fix_scale = true;
  uint64_t seed = 1;

  // Number of covisible keyframes of either side whose points take part.
  int neighbours = 5;
  int min_word_matches = 20;
  int min_ransac_inliers = 15;
  int min_refined_inliers = 25;
  int min_projected_matches = 40;
  // The projected matches must also be this many times what is found when looking beside where the
  // points should be: where many keypoints are, some match by chance. Parts of another place may
  // look the same (one house of a street), so that more has to be found where little is of all that
  // should be seen there.
  double min_projected_to_chance = 5;
  double min_projected_share = 0.1;
  double min_projected_to_chance_of_few = 10;
  // Number of further pairs of keyframes that must agree, and of the matches that make a pair
  // agree.
  int min_consistent_keyframes = 2;
  int min_matches_per_keyframe = 25;
  // Largest |scale - 1| where the scale is estimated between maps that should be metric. It is
  // ignored for monocular cameras.
  double max_scale_deviation = 0.05;
  // Largest standard deviation of the scale's logarithm where a side has no metres: a merge by a
  // scale that is not known puts what lies behind the overlap elsewhere.
  double max_log_scale_sigma = 0.02;
};

// Returns the verdict, with the counts of the stages that were reached. The views may be one and
// the same map (loops), the query and candidate must not be the same keyframe. A keyframe that its
// view does not hold matches nothing. Deterministic and pure; it takes milliseconds to tens of
// them. `evidence.shared_words` is left at 0 for the caller to fill in.
Overlap VerifyPlace(const Map& query_view, KeyframeId query, const Map& candidate_view,
                    KeyframeId candidate, const PlaceVerificationOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VERIFICATION_PLACE_VERIFICATION_H_
