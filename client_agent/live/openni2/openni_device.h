// A device, or a recording, that OpenNI 2 reads: a colour (or grey) picture and its depth.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_DEVICE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_DEVICE_H_

#include <OpenNI.h>

#include <atomic>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client_agent/live/picture_pairing.h"

namespace corbslam::client_agent {

struct OpenNiOptions {
  std::string uri;  // A device's, or a recording's path. Empty: the first device that is there.
  cv::Size colour_px;
  cv::Size depth_px;  // Of depth that the device does not register; else it has colour_px.
  // Nullopt: the device registers depth where it can.
  std::optional<bool> device_registers;
  std::optional<double> rate_hz;
  double units_per_m = 1000;
};

// Thread-compatible.
class OpenNiDevice {
 public:
  // Opens the device, chooses its modes, turns mirroring off and starts it. NOT_FOUND where it is
  // not there; INVALID_ARGUMENT names what it has, where it has no such pictures or another unit.
  static absl::StatusOr<std::unique_ptr<OpenNiDevice>> Open(const OpenNiOptions& options);
  ~OpenNiDevice();

  const std::string& uri() const { return uri_; }
  bool is_recording() { return device_.isFile(); }
  // The device registers depth, or recorded it so.
  bool registers() const { return registers_; }

  struct Picture {
    LiveSide side;
    int64_t stamp_us;  // The device's.
    cv::Mat image;     // CV_8UC1 or CV_16UC1, not mirrored.
  };
  // Waits for the next picture of either side; nullopt where none came. OUT_OF_RANGE at a
  // recording's end, UNAVAILABLE where the device has gone.
  absl::StatusOr<std::optional<Picture>> Next(absl::Duration wait);

 private:
  class Gone;
  OpenNiDevice() = default;
  absl::Status Start(const OpenNiOptions& options);
  absl::Status Register(const OpenNiOptions& options);
  absl::Status SetUp(openni::VideoStream& stream, openni::SensorType type, const cv::Size& size,
                     const OpenNiOptions& options);
  absl::Status CheckUnits(double units_per_m) const;
  // Returns true if every picture of both streams was read.
  bool IsAtEnd();

  std::string uri_;
  openni::Device device_;
  openni::VideoStream colour_;
  openni::VideoStream depth_;
  bool registers_ = false;
  bool flips_[2] = {false, false};  // Mirrored pictures that can't be had otherwise, by LiveSide.
  int last_index_[2] = {0, 0};
  std::unique_ptr<Gone> gone_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_DEVICE_H_
