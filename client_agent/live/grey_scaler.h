// Makes 8 bits of a live camera's grey pictures of 16.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GREY_SCALER_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GREY_SCALER_H_

#include <cstddef>
#include <opencv2/core/mat.hpp>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::client_agent {

// Cameras use 10, 12, 14 or all of 16 bits. The pictures that came show how many, as a recording's
// do (DecideGreyDepth), and whether all is dark: one decision for both cameras of a pair, which a
// brighter picture corrects upwards, and which is logged. Thread-safe.
class GreyScaler {
 public:
  // Returns CV_8UC1 of CV_16UC1; CV_8UC1 as it is.
  cv::Mat ToEightBits(const cv::Mat& grey) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  absl::Mutex mutex_;
  int white_ ABSL_GUARDED_BY(mutex_) = 0;  // GreyDepth::White; 0: no picture showed anything yet.
  size_t pictures_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GREY_SCALER_H_
