// The camera of a ros2: source: what a driver for ROS 2 publishes.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_CAMERA_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_CAMERA_H_

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "client_agent/live/grey_scaler.h"
#include "client_agent/live/live_stream.h"
#include "client_agent/live/ros2/ros2_context.h"
#include "client_agent/live/ros2/ros2_rig.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::client_agent {

struct Ros2CameraOptions {
  std::optional<Rig> rig = std::nullopt;         // Instead of CameraInfo.
  std::optional<bool> registers = std::nullopt;  // As LiveOptions'.
  bool trust_calibration = false;
};

// Subscribes from the beginning. Messages are decoded on the node's thread.
class Ros2Camera : public LiveCamera {
 public:
  static constexpr absl::Duration kToldFirst = absl::Seconds(3);
  static constexpr absl::Duration kToldAgain = absl::Seconds(10);
  // A calibration that is not possible, though all is there, ends the waiting.
  static constexpr absl::Duration kPatience = absl::Seconds(30);

  static absl::StatusOr<std::unique_ptr<Ros2Camera>> Open(std::shared_ptr<Ros2Context> context,
                                                          const Ros2CameraOptions& options);
  ~Ros2Camera() override { Stop(); }

  // Returns the rig, with base_frame as its body. Waits for the driver and for /tf_static as long
  // as it takes; what is missing is logged after kToldFirst, and again each kToldAgain, with what
  // to do. CANCELLED after `stop`; INVALID_ARGUMENT where what is there makes no rig.
  absl::StatusOr<Rig> AwaitRig(const absl::Notification& stop);

  absl::Status Start(PicturePairing& pairing) override ABSL_LOCKS_EXCLUDED(mutex_);
  void Stop() override ABSL_LOCKS_EXCLUDED(mutex_);
  LiveImu* imu() override { return context_->settings().uses_imu ? &imu_ : nullptr; }

 private:
  Ros2Camera(std::shared_ptr<Ros2Context> context, const Ros2CameraOptions& options)
      : context_(std::move(context)), options_(options) {}
  absl::Status SubscribeAll();
  absl::Status SubscribePictures(size_t side);

  // Takes a message of Image or CompressedImage.
  template <typename Message>
  void OnPicture(size_t side, const Message& message) ABSL_LOCKS_EXCLUDED(mutex_);
  template <typename Picture>
  absl::StatusOr<cv::Mat> Decode(size_t side, const Picture& picture);
  void OnImu(const void* sample) ABSL_LOCKS_EXCLUDED(mutex_);
  // Logs what is left out: the first, and then one in so many.
  void LeaveOut(size_t side, const std::string& why) ABSL_LOCKS_EXCLUDED(mutex_);

  // Returns what there is no message of yet, a sentence each.
  std::vector<std::string> MissingMessages() const ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<Rig> MakeRig() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Each puts what /tf_static says into the rig; NOT_FOUND names the frames.
  absl::Status PlaceBase(const std::string& camera_frame, Rig& rig) const;
  absl::Status PlaceImu(const std::string& camera_frame, Rig& rig) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  std::string CameraFrame() const ABSL_LOCKS_EXCLUDED(mutex_);
  void TellContext(const Rig& rig) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::shared_ptr<Ros2Context> context_;
  const Ros2CameraOptions options_;
  const Ros2Subscription* images_[2] = {nullptr, nullptr};
  const Ros2Subscription* infos_[2] = {nullptr, nullptr};
  const Ros2Subscription* imu_topic_ = nullptr;
  GreyScaler grey_;
  LiveImu imu_;

  mutable absl::Mutex mutex_;
  Ros2Side sides_[2] ABSL_GUARDED_BY(mutex_);
  uint64_t left_out_[2] ABSL_GUARDED_BY(mutex_) = {0, 0};
  std::string imu_frame_ ABSL_GUARDED_BY(mutex_);
  int64_t newest_imu_ns_ ABSL_GUARDED_BY(mutex_) = INT64_MIN;
  PicturePairing* pairing_ ABSL_GUARDED_BY(mutex_) = nullptr;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_CAMERA_H_
