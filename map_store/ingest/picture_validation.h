// Checks keyframes' pictures before they are kept, by their headers alone: nothing is decoded.
#ifndef CORBSLAM_MAP_STORE_INGEST_PICTURE_VALIDATION_H_
#define CORBSLAM_MAP_STORE_INGEST_PICTURE_VALIDATION_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Most pixels of a picture's width and of its height: browsers decode what is kept.
inline constexpr int kMaxPictureSide_px = 4096;

// INVALID_ARGUMENT, with what is wrong, unless the bytes are a whole JPEG of 8 bits and one colour,
// of at most kMaxPictureSide_px each way.
absl::Status ValidateGreyJpeg(absl::string_view jpeg);

// INVALID_ARGUMENT names the keyframe, the value and its limit.
absl::Status ValidatePicture(const KeyframePicture& picture);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_PICTURE_VALIDATION_H_
