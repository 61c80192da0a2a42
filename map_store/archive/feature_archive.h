// Turns a keyframe's features to bytes and back.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_FEATURE_ARCHIVE_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_FEATURE_ARCHIVE_H_

#include <functional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "slam/features/keypoint.h"
#include "slam/map/keyframe.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Returns a keyframe's features. NOT_FOUND and DATA_LOSS name the keyframe.
using FeatureLoader = std::function<absl::StatusOr<Features>(KeyframeId)>;

// Encodes features: coded (slam/coding/feature_coding.h) where that keeps every bit and is shorter,
// else as plain numbers. The features of each keyframe can be read alone.
std::string EncodeFeatures(const KeyframePayload& payload);
// Returns DATA_LOSS where the bytes are not what EncodeFeatures made.
absl::StatusOr<Features> DecodeFeatures(std::string_view bytes);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_FEATURE_ARCHIVE_H_
