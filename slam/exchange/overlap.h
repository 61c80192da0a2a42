// A place that two keyframes saw, and how it was (or was not) verified.
#ifndef CORBSLAM_SLAM_EXCHANGE_OVERLAP_H_
#define CORBSLAM_SLAM_EXCHANGE_OVERLAP_H_

#include <string>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam {

// Counts at each stage of verification, kept whatever the verdict.
struct OverlapEvidence {
  int shared_words = 0;          // Words that both bags of words hold.
  int word_matches = 0;          // Keypoint pairs found by the direct index.
  int ransac_inliers = 0;        // Inliers of the similarity (Horn) or the pose (PnP).
  int guided_matches = 0;        // Matches after the guided search.
  int refined_inliers = 0;       // Inliers after refinement on all matches.
  int projected_matches = 0;     // Points of the candidate's neighbourhood found in the query.
  int visible_points = 0;        // Points among these that should be in the query's picture.
  int chance_matches = 0;        // Matches of the same points, looked for where they should not be.
  int consistent_keyframes = 0;  // Further keyframe pairs that agree.
};

enum class OverlapVerdict {
  kAccepted,
  kTooFewWordMatches,
  kTooFewRansacInliers,
  kTooFewRefinedInliers,
  kTooFewProjectedMatches,
  kNoSecondKeyframe,
  kWrongScale,
  kBendsGraph,  // Fusing refused it later.
  kTakenBack,   // Somebody who knows better took it back.
};
// Returns "ACCEPTED", "TOO_FEW_WORD_MATCHES" and so on.
std::string ToString(OverlapVerdict verdict);

// True for a covariance: it is finite, symmetric, and has no eigenvalue below 0 beyond rounding.
bool IsCovariance(const Matrix7d& matrix);

struct PointPair {
  MapPointId query;
  MapPointId candidate;
  friend auto operator<=>(const PointPair&, const PointPair&) = default;
};

struct Overlap {
  KeyframeId query;
  KeyframeId candidate;
  // x_in_candidate_camera = candidate_from_query * x_in_query_camera. It is the identity before
  // verification.
  Similarity3d candidate_from_query;
  // Covariance of e, where the true similarity is Exp(e) * candidate_from_query: translation in
  // units of the candidate's map, rotation in rad, log of scale (SimilarityCovariance). Rows of a
  // fixed scale are 0; all rows are 0 where it is not known.
  Matrix7d covariance = Matrix7d::Zero();
  std::vector<PointPair> inliers;
  OverlapEvidence evidence;
  OverlapVerdict verdict = OverlapVerdict::kTooFewWordMatches;

  bool IsAccepted() const { return verdict == OverlapVerdict::kAccepted; }
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_OVERLAP_H_
