// What a picture file says of itself before anybody decodes it.
#ifndef CORBSLAM_SLAM_SENSOR_PICTURE_HEADER_H_
#define CORBSLAM_SLAM_SENSOR_PICTURE_HEADER_H_

#include <opencv2/core/types.hpp>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam {

// Returns whether a PNG or JPEG lacks the mark of its end. Decoders paint what is missing grey, and
// say nothing. Other files have no such mark: false.
bool IsCutShort(absl::string_view encoded);

// Returns the size, in pixels, that the header of a PNG or JPEG names. INVALID_ARGUMENT: it is
// neither, or its header is damaged.
absl::StatusOr<cv::Size> PictureSize(absl::string_view encoded);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_PICTURE_HEADER_H_
