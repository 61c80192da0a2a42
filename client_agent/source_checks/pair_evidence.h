// Gathers what the matches of left and right pictures say for and against the pairs of a sample.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PAIR_EVIDENCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PAIR_EVIDENCE_H_

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source_checks/feature_matches.h"
#include "client_agent/source_checks/sample.h"
#include "slam/camera/rectification.h"

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

struct JudgedPair {
  size_t number = 0;
  PairEvidence evidence;
  // Evidence of the left picture with the right one of the frame before and after, where those are
  // in the sample.
  std::optional<PairEvidence> with_before;
  std::optional<PairEvidence> with_after;
  // Matches of the rectified pictures whose rows are at most 40 pixels apart. In the right one they
  // lie right_cx_offset_px farther left, so that their disparities are right.
  std::vector<FeatureMatch> matches;
};

// Rectifies where the calibration is raw.
class PairPreparation {
 public:
  // INVALID_ARGUMENT is for an impossible calibration.
  static absl::StatusOr<PairPreparation> Make(const StereoCalibration& calibration);

  // The camera of the rectified pair.
  const Camera& camera() const { return camera_; }
  bool rectifies() const { return rectifier_.has_value(); }
  // StereoCalibration::right_cx_offset_px.
  double right_cx_offset_px() const { return right_cx_offset_px_; }
  // Returns the pictures as they are matched: rectified, or as they are; nullopt where they have
  // another size than the calibration's.
  struct Pictures {
    cv::Mat left;
    cv::Mat right;
  };
  std::optional<Pictures> Rectify(const SensorImages& images, bool exchanged = false) const;

  // Judges every pair of the right size and with enough features on both sides, in order.
  // `exchanged` takes the left picture for the right one and the other way round.
  std::vector<JudgedPair> Judge(const Sample& sample, bool exchanged = false) const;
  // Returns the share of the features of a left picture that match in that of the next frame,
  // median over the sample: hardly any match where they are noise on a bare wall. 0 without
  // neighbouring frames.
  double MatchShareInTime(const Sample& sample) const;

 private:
  struct Sides {
    CheckFeatures left;
    CheckFeatures right;
  };
  PairPreparation() = default;
  std::optional<Sides> Extract(const SensorImages& images, bool exchanged) const;
  // Returns nothing where a side has too few features.
  std::optional<std::vector<FeatureMatch>> Match(const std::optional<Sides>& left,
                                                 const std::optional<Sides>& right) const;
  PairEvidence Weigh(const Sides& left, const Sides& right,
                     const std::vector<FeatureMatch>& matches) const;
  std::optional<PairEvidence> Compare(const std::optional<Sides>& left,
                                      const std::optional<Sides>& right) const;

  Camera camera_;
  std::optional<StereoRectifier> rectifier_;
  double right_cx_offset_px_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PAIR_EVIDENCE_H_
