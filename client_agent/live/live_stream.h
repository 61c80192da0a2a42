// Plays a camera: the stream of frames of something that gives pictures by itself.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_LIVE_STREAM_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_LIVE_STREAM_H_

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client_agent/live/live_imu.h"
#include "client_agent/live/picture_pairing.h"
#include "client_agent/live/rate_watch.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/rig/rig.h"
#include "client_agent/source/rig/rig_depth.h"

namespace corbslam::client_agent {

// A camera, or two, that push pictures into a PicturePairing from their own threads between Start
// and Stop. It ends the pairing itself where no more pictures will come.
class LiveCamera {
 public:
  virtual ~LiveCamera() = default;
  // Errors say what to do: no such device, a pipeline that can't be understood. The pairing
  // outlives the camera.
  virtual absl::Status Start(PicturePairing& pairing) = 0;
  virtual void Stop() = 0;
  // As FrameStream's.
  virtual PoseListener* pose_listener() { return nullptr; }
  // Returns what its IMU measures, which lives as long as the camera; null: it gives no samples.
  virtual LiveImu* imu() { return nullptr; }
};

struct LiveOptions {
  std::string name;  // For messages: what the user called the source.
  int64_t pair_within_ns = 5'000'000;
  // RGB-D: whether depth is registered to the pictures here; nullopt: as the rig says. False where
  // the device or its pipeline does it.
  std::optional<bool> registers = {};
  // Both pictures of a frame have one stamp: the rig's time_offset_s is not used, which is said.
  bool one_stamp = false;
};

// Frames are the newest there are. Pictures of another size or type than the rig's are left out;
// when kMostWrong of them come in a row, the stream ends with what was wanted and what came;
// likewise where kMostAlone pictures of each side came and no two of them are a frame. A rate that
// falls is logged.
class LiveStream : public FrameStream {
 public:
  // Returns what Open would refuse of the rig and the options, without a camera.
  static absl::Status Check(const Rig& rig, const LiveOptions& options);
  // Starts the camera. INVALID_ARGUMENT for an impossible rig.
  static absl::StatusOr<std::unique_ptr<FrameStream>> Open(const Rig& rig,
                                                           std::unique_ptr<LiveCamera> camera,
                                                           const LiveOptions& options);
  ~LiveStream() override;

  const SensorCalibration& calibration() const override { return calibration_; }
  std::optional<double> interval_s() const override;
  absl::StatusOr<NextFrame> Next(absl::Time deadline) override;
  LeftOutFrames left_out() const override;
  SourceFindings findings() const override { return findings_; }
  uint64_t overtaken() const override { return pairing_.counts().overtaken; }
  std::optional<CameraCounts> camera_counts() const override { return pairing_.counts(); }
  PoseListener* pose_listener() override { return camera_->pose_listener(); }

 private:
  LiveStream(const Rig& rig, SensorCalibration calibration, DepthPreparation depth,
             std::unique_ptr<LiveCamera> camera, const LiveOptions& options);
  void UseImu(const Rig& rig);
  absl::Status CheckPictures(const LivePair& pair) const;
  // Returns a checked pair as a frame, its depth prepared.
  absl::StatusOr<StreamFrame> FrameOf(const LivePair& pair) const;
  // Logs a rate that changes, and that no frame comes though pictures do.
  void TellRate();
  // Returns what helps where pictures have no counterpart; empty where nothing is known.
  std::string AdvicePairs(const CameraCounts& counts) const;
  // Returns an error where both sides give pictures that are never of one time.
  absl::Status CheckPaired() const;
  absl::StatusOr<NextFrame> LeaveOut(const LivePair& pair, const absl::Status& why);

  const LiveOptions options_;
  const std::optional<double> rate_hz_;
  SensorCalibration calibration_;  // Without an IMU where the camera gives no samples.
  const DepthPreparation depth_;   // RGB-D only.
  PicturePairing pairing_;
  RateWatch rate_;
  SourceFindings findings_;
  // Frames that had come when it was looked at, and the pictures of both sides by then.
  uint64_t frames_ = 0;
  uint64_t pictures_at_frame_ = 0;
  LeftOutFrames wrong_;
  size_t wrong_in_a_row_ = 0;
  bool ended_ = false;
  std::unique_ptr<LiveCamera> camera_;
};

constexpr size_t kMostWrong = 10;
constexpr uint64_t kMostAlone = 50;

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_LIVE_STREAM_H_
