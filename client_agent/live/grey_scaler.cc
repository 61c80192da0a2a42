#include "client_agent/live/grey_scaler.h"

#include <glog/logging.h>

#include <opencv2/core.hpp>

#include "client_agent/source/pictures/grey_depth.h"

namespace corbslam::client_agent {
namespace {

// Each of the first pictures is looked at, and later one of so many.
constexpr size_t kFirst = 30;
constexpr size_t kEach = 30;

}  // namespace

cv::Mat GreyScaler::ToEightBits(const cv::Mat& grey) {
  if (grey.type() != CV_16UC1) return grey;
  const absl::MutexLock lock(&mutex_);
  const bool looks = pictures_ < kFirst || pictures_ % kEach == 0 || used_bits_ == 0;
  ++pictures_;
  if (looks && cv::countNonZero(grey) > 0) {
    const GreyDepth seen = DecideGreyDepth({&grey, 1});
    if (seen.used_bits > used_bits_) {
      used_bits_ = seen.used_bits;
      for (const SourceFinding& finding : seen.findings) {
        LOG(WARNING) << finding.text << " [" << finding.code << "]";
      }
    }
  }
  return ScaleGreyTo8(grey, used_bits_ == 0 ? 16 : used_bits_);
}

}  // namespace corbslam::client_agent
