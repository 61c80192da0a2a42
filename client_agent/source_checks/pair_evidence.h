// Gathers what the matches of a left and a right picture say about the pair.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PAIR_EVIDENCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PAIR_EVIDENCE_H_

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <vector>

#include "client_agent/source_checks/feature_matches.h"

namespace corbslam::client_agent {

// How rows of the right picture lie against the left one's:
// y_right - y_left = offset_px + roll_rad (x - width / 2) + stretch (y - height / 2).
struct RowFit {
  double offset_px = 0;
  double roll_rad = 0;
  double stretch = 0;
};

struct PairEvidence {
  size_t features = 0;  // Features of the picture that has fewer.
  size_t matches = 0;
  // Matches that agree with the best RowFit: what is left of a pair that has been mounted askew.
  size_t related = 0;
  // How well the rows of all matches agree without a fit, as they do in a rectified pair: each
  // match counts 1 where they are the same, down to 0 at kRowBand_px of its octave.
  double row_score = 0;
  RowFit fit;
  // Medians over the related matches: by how much the fit says that rows differ, and the error that
  // it leaves.
  double row_error_px = 0;
  double residual_px = 0;
  // Related matches whose disparity x_left - x_right is clearly positive or negative, and those
  // that have moved in neither direction by as much as half a pixel.
  size_t positive = 0;
  size_t negative = 0;
  size_t unmoved = 0;
  double median_disparity_px = 0;  // Median of the positive ones; 0 without any.
};

// `features` as in PairEvidence; `matches` are those of the two pictures of `size`.
PairEvidence GatherPairEvidence(size_t features, const std::vector<FeatureMatch>& matches,
                                const cv::Size& size);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PAIR_EVIDENCE_H_
