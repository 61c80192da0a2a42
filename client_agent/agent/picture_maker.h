// Makes keyframes' pictures on a thread of its own, so that tracking waits for none.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_PICTURE_MAKER_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_PICTURE_MAKER_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "slam/exchange/uplink.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// Thread-safe.
class PictureMaker {
 public:
  using Take = std::function<void(KeyframePicture)>;

  // `take` is called on the thread, until the maker is destroyed. `width_px` is
  // PictureEncoder::Make's.
  PictureMaker(SensorCalibration calibration, int width_px, Take take);
  ~PictureMaker();
  PictureMaker(const PictureMaker&) = delete;
  PictureMaker& operator=(const PictureMaker&) = delete;

  // Keeps what a keyframe's camera saw, as it was recorded, until the thread has time. The pixels
  // are shared, not copied. Where too many wait, the oldest is left out.
  void Add(KeyframeId keyframe, const cv::Mat& grey) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns once everything that was added was taken.
  void Finish() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  static constexpr size_t kMaxWaiting = 4;

  struct Seen {
    KeyframeId keyframe;
    cv::Mat grey;
  };
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);

  const SensorCalibration calibration_;
  const int width_px_;
  const Take take_;
  absl::Mutex mutex_;
  std::deque<Seen> waiting_ ABSL_GUARDED_BY(mutex_);
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_PICTURE_MAKER_H_
