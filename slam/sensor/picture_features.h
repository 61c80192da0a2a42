// Reads a picture file and finds its features: the way from somebody's photograph to what a map's
// keyframes are made of.
#ifndef CORBSLAM_SLAM_SENSOR_PICTURE_FEATURES_H_
#define CORBSLAM_SLAM_SENSOR_PICTURE_FEATURES_H_

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/camera/camera.h"
#include "slam/camera/lens.h"
#include "slam/features/keypoint.h"

namespace corbslam {

// Limits of a picture.
inline constexpr size_t kMaxEncodedBytes = size_t{3} << 20;
inline constexpr int64_t kMaxPicturePixels = 64'000'000;
inline constexpr int kMinPictureSide_px = 64;
inline constexpr int kMinPictureFeatures = 100;
inline constexpr int kMaxPictureFeatures = 10'000;

// Decodes a PNG or JPEG to grey (CV_8UC1, as it lies in the file: orientation tags don't turn it).
// INVALID_ARGUMENT, with the limit, for what is no such picture, or too large or too small; a
// picture whose header claims more pixels than there may be is not decoded.
absl::StatusOr<cv::Mat> DecodePicture(absl::string_view encoded);

struct PictureFeatures {
  Features features;  // In the pixels of `camera`.
  Camera camera;      // The pinhole without distortion, monocular, of the picture's size.
};

// Finds up to `wanted` features of a grey picture and moves them to where a pinhole with the
// intrinsics of `lens` would see them. Those that it would see farther than one side of the picture
// outside of it are left out. INVALID_ARGUMENT for an impossible camera.
absl::StatusOr<PictureFeatures> FindPictureFeatures(const cv::Mat& grey, const RawCamera& lens,
                                                    int wanted);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_PICTURE_FEATURES_H_
