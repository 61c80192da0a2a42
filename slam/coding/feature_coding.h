// A picture's features as few bytes, without loss (docs/wire.md, docs/adr/0018-coded-features.md).
// What is coded stands for itself: nothing that was coded before is needed to read it.
#ifndef CORBSLAM_SLAM_CODING_FEATURE_CODING_H_
#define CORBSLAM_SLAM_CODING_FEATURE_CODING_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "slam/coding/feature_columns.h"
#include "slam/coding/keypoint_model.h"

namespace corbslam {

// Version of the format. A change of a model or of its weights needs another version.
inline constexpr uint8_t kFeatureCodingVersion = 1;
// Coded features are at least so long. Cameras' features are five times as long; it bounds what a
// few bytes can make a reader do.
inline constexpr size_t kMinCodedBytesOfKeypoint = 4;

// Returns none where features are better kept as they are, because code of the format isn't
// shorter, can't be made, or would be too short for the bound above.
std::optional<std::string> EncodeFeatures(const FeatureColumns& columns,
                                          const PictureSize& picture);

// INVALID_ARGUMENT, naming what is wrong: another version, cut short, too long, more than
// `max_keypoints`, or not what an encoder has made. Values are checked by nobody: they are any that
// fit into the columns. Time and memory are in proportion to the length.
absl::StatusOr<FeatureColumns> DecodeFeatures(std::string_view bytes, size_t max_keypoints);

// Returns the number of keypoints that `bytes` state, at most what their length allows; 0 where
// that can't be read.
size_t CountCodedKeypoints(std::string_view bytes);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_FEATURE_CODING_H_
