// Features as columns of whole numbers: what travels and is kept of them (docs/wire.md).
#ifndef CORBSLAM_SLAM_CODING_FEATURE_COLUMNS_H_
#define CORBSLAM_SLAM_CODING_FEATURE_COLUMNS_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "slam/features/keypoint.h"

namespace corbslam {

inline constexpr double kPositionSteps_px = 64;
inline constexpr double kDisparitySteps_px = 128;
inline constexpr uint32_t kMaxDisparity_px128 = 1u << 21;
inline constexpr uint32_t kTurnSteps = 1u << 14;

// The columns are parallel, with one entry a keypoint.
struct FeatureColumns {
  std::vector<int32_t> x_px64;
  std::vector<int32_t> y_px64;
  std::vector<uint32_t> disparity_px128;  // 0: unknown. An empty column: all are unknown.
  std::vector<uint32_t> angle_turn14;     // Less than kTurnSteps.
  std::string octaves;                    // One byte each.
  std::vector<Descriptor> descriptors;    // May be empty.

  size_t size() const { return x_px64.size(); }
  friend bool operator==(const FeatureColumns&, const FeatureColumns&) = default;
};

// Rounds to the steps above. A known disparity stays known.
FeatureColumns ToColumns(const Features& features);
// Columns that were rounded once pass again unchanged. They must be of one length (disparities and
// descriptors may be empty).
Features FromColumns(FeatureColumns columns);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_FEATURE_COLUMNS_H_
