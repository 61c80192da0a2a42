// The camera of a push: source: another program on this machine that gives pictures.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_CAMERA_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_CAMERA_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "client_agent/live/live_stream.h"
#include "client_agent/live/push/push_driver.h"
#include "client_agent/live/push/unix_socket.h"
#include "client_agent/source/pose_listener.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::client_agent {

struct PushCameraOptions {
  std::string path;                       // Of the socket.
  std::optional<Rig> rig = std::nullopt;  // Absent: the first driver says it.
  bool trust_calibration = false;         // Of a driver's rig.
};

// Listens for drivers, one at a time. What a driver says wrongly is told to it and ends its
// connection; a driver that goes is waited for, or for another one, whose times may begin anew.
// Poses go back to the driver as of the (left) camera as it records. Pairs that come have one time,
// so that they need no pairing.
class PushCamera : public LiveCamera, private PushHost, private PoseListener {
 public:
  // Listens from now on; errors are UnixListener::Listen's. A rig is to be possible.
  static absl::StatusOr<std::unique_ptr<PushCamera>> Open(const PushCameraOptions& options);
  ~PushCamera() override { Stop(); }

  // Returns the rig; waits for a driver that says it, where it must. CANCELLED after `stop`.
  absl::StatusOr<Rig> AwaitRig(const absl::Notification& stop);

  absl::Status Start(PicturePairing& pairing) override;
  void Stop() override;
  PoseListener* pose_listener() override { return this; }
  LiveImu* imu() override { return &imu_; }

 private:
  PushCamera(const PushCameraOptions& options, UnixListener listener, UniqueFd wake)
      : options_(options), listener_(std::move(listener)), wake_(std::move(wake)) {}

  absl::Status OnHello(const PushHello& hello) override;
  absl::Status OnFrame(int64_t timestamp_ns, cv::Mat first, cv::Mat second) override;
  bool takes_imu() const override { return rig_.has_value() && rig_->imu.has_value(); }
  absl::Status OnImu(const ImuSamples& samples) override;
  void OnPose(const FramePose& pose) override ABSL_LOCKS_EXCLUDED(mutex_);

  // Checks a rig and takes it.
  absl::Status UseRig(const Rig& rig);
  absl::Status UseDriversRig(const PushHello& hello);
  // Waits for anything to do, at most a moment, and does one thing of each kind.
  void Step();
  // INVALID_ARGUMENT where another clock than CLOCK_MONOTONIC must have made the time.
  static absl::Status CheckClock(int64_t timestamp_ns);
  // Reads one message, or all that are left of a driver that went.
  absl::Status ServeDriver(bool readable, bool went);
  void AcceptOne();
  void TakePoses() ABSL_LOCKS_EXCLUDED(mutex_);

  const PushCameraOptions options_;
  const UnixListener listener_;
  const UniqueFd wake_;  // An eventfd: there is something to do beside the sockets.
  std::optional<PushDriver> driver_;
  std::optional<Rig> rig_;
  bool rig_is_told_ = false;  // A driver's rig that is not used was logged.
  std::optional<Rigid3d> camera_from_recorded_;
  int64_t newest_ns_ = -1;      // Of the driver; the pairing knows what came of those before.
  int64_t newest_imu_ns_ = -1;  // Of the driver.
  PicturePairing* pairing_ = nullptr;
  LiveImu imu_;
  absl::Notification stop_;
  std::thread thread_;

  absl::Mutex mutex_;
  std::vector<std::string> poses_ ABSL_GUARDED_BY(mutex_);  // To be sent.
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_CAMERA_H_
