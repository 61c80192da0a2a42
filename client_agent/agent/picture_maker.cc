#include "client_agent/agent/picture_maker.h"

#include <glog/logging.h>

#include <utility>

#include "client_agent/agent/picture_encoder.h"
#include "slam/util/named_thread.h"

namespace corbslam::client_agent {

PictureMaker::PictureMaker(SensorCalibration calibration, int width_px, Take take)
    : calibration_(std::move(calibration)), width_px_(width_px), take_(std::move(take)) {
  thread_ = StartThread("picture maker", [this] { Run(); });
}

PictureMaker::~PictureMaker() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  thread_.join();
}

void PictureMaker::Add(KeyframeId keyframe, const cv::Mat& grey) {
  absl::MutexLock lock(&mutex_);
  waiting_.push_back({keyframe, grey});
  if (waiting_.size() > kMaxWaiting) waiting_.pop_front();
}

void PictureMaker::Finish() {
  absl::MutexLock lock(&mutex_);
  const auto idle = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stop_ || (waiting_.empty() && !busy_);
  };
  mutex_.Await(absl::Condition(&idle));
}

void PictureMaker::Run() {
  const auto has_work = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stop_ || !waiting_.empty();
  };
  const absl::StatusOr<PictureEncoder> encoder = PictureEncoder::Make(calibration_, width_px_);
  LOG_IF(WARNING, !encoder.ok()) << "no pictures of keyframes go up: " << encoder.status();
  while (true) {
    Seen seen;
    {
      absl::MutexLock lock(&mutex_);
      busy_ = false;
      mutex_.Await(absl::Condition(&has_work));
      if (stop_) return;
      seen = std::move(waiting_.front());
      waiting_.pop_front();
      busy_ = true;
    }
    if (!encoder.ok()) continue;
    absl::StatusOr<PictureEncoder::Encoded> encoded = encoder->Encode(seen.grey);
    if (encoded.ok()) {
      take_({seen.keyframe, std::move(encoded->jpeg), encoded->scale});
    } else {
      LOG_FIRST_N(WARNING, 3) << "keyframe " << ToString(seen.keyframe)
                              << " has no picture: " << encoded.status();
    }
  }
}

}  // namespace corbslam::client_agent
