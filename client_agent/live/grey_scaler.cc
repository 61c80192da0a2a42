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
  const bool looks = pictures_ < kFirst || pictures_ % kEach == 0 || white_ == 0;
  ++pictures_;
  if (looks && cv::countNonZero(grey) > 0) {
    const GreyDepth seen = DecideGreyDepth({&grey, 1});
    if (seen.White() > white_) {
      white_ = seen.White();
      for (const SourceFinding& finding : seen.findings) {
        LOG(WARNING) << finding.text << " [" << finding.code << "]";
      }
    }
  }
  return ScaleGreyTo8(grey, white_ == 0 ? 1 << 16 : white_);
}

}  // namespace corbslam::client_agent
