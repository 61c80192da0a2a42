// Gives pictures to a robot's own GStreamer pipeline, as a camera on the network does.
#ifndef CORBSLAM_TESTS_LIVE_CAMERA_CAMERA_SERVER_H_
#define CORBSLAM_TESTS_LIVE_CAMERA_CAMERA_SERVER_H_

#include <memory>
#include <opencv2/core/mat.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace corbslam::tests {

// Writes raw pictures as Matroska to who connects: "gst:tcpclientsrc host=127.0.0.1 port=N !
// matroskademux" reads them with the times at which they were taken, to the millisecond. Neither
// raw video over TCP nor shared memory (shmsrc) carries any.
class CameraServer {
 public:
  // Pictures are CV_8UC1 of this size. `port` 0: the system chooses one. UNAVAILABLE says what
  // GStreamer misses.
  static absl::StatusOr<std::unique_ptr<CameraServer>> Start(const cv::Size& size, int port);
  virtual ~CameraServer() = default;  // The camera is unplugged: its port is closed.

  virtual int port() const = 0;
  // Waits for the first robot. DEADLINE_EXCEEDED: none came.
  virtual absl::Status WaitForRobot(absl::Duration timeout) = 0;
  // `stamp` counts from the server's start. Pictures go out at once.
  virtual absl::Status Give(const cv::Mat& picture, absl::Duration stamp) = 0;
  // Says that no more will come and lets what was given go out.
  virtual void Finish() = 0;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_LIVE_CAMERA_CAMERA_SERVER_H_
