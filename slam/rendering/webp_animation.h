// Writes animated WebP, which browsers show as they show pictures.
#ifndef CORBSLAM_SLAM_RENDERING_WEBP_ANIMATION_H_
#define CORBSLAM_SLAM_RENDERING_WEBP_ANIMATION_H_

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam {

// Not thread-safe. Frames are compressed as they come, without loss: lines stay sharp, and what
// stands still costs nothing.
class WebpAnimation {
 public:
  static constexpr size_t kMostFrames = 1000;
  static constexpr int kLargestSide_px = 16383;  // WebP's own limit.

  // `frames_per_second` is 5 to 20. INVALID_ARGUMENT names the value and its limits.
  static absl::StatusOr<WebpAnimation> Create(int frames_per_second);

  // Adds an 8-bit BGR picture; all have the size of the first. INVALID_ARGUMENT if not, and from
  // the 1,001st frame on.
  absl::Status Add(const cv::Mat& image);

  // Returns the file's bytes; the last frame stays for two seconds before it begins again.
  absl::StatusOr<std::string> Finish();

 private:
  struct Encoder;
  explicit WebpAnimation(int frames_per_second);

  std::shared_ptr<Encoder> encoder_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_WEBP_ANIMATION_H_
