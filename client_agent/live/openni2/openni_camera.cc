#include "client_agent/live/openni2/openni_camera.h"

#include <glog/logging.h>

#include <chrono>
#include <utility>

#include "absl/synchronization/notification.h"
#include "client_agent/live/openni2/lasting_thread.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::Duration kBetweenStarts = absl::Seconds(1);
constexpr absl::Duration kWait = absl::Milliseconds(300);

// Returns CLOCK_MONOTONIC, which never jumps.
int64_t Now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class OpenNiCamera : public LiveCamera {
 public:
  OpenNiCamera(std::unique_ptr<OpenNiDevice> device, const OpenNiOptions& options,
               std::optional<bool> restarts)
      : options_(options), restarts_(restarts), device_(std::move(device)) {}
  ~OpenNiCamera() override { Stop(); }

  absl::Status Start(PicturePairing& pairing) override {
    pairing_ = &pairing;
    kept_ = RunOnLastingThread([this] { Keep(); });
    return absl::OkStatus();
  }
  void Stop() override {
    if (!stop_.HasBeenNotified()) stop_.Notify();
    if (kept_ != nullptr) kept_->WaitForNotification();
  }

 private:
  // Runs until it is stopped or the device ends for good.
  void Keep() {
    while (true) {
      const absl::Status ended = Play();
      if (stop_.HasBeenNotified()) return;
      const bool at_end = absl::IsOutOfRange(ended);
      if (!restarts_.value_or(!at_end)) {
        return pairing_->End(at_end ? absl::OkStatus() : ended);
      }
      LOG(WARNING) << "the camera went away: " << ended.message()
                   << "; waiting for it to come back";
      device_.reset();
      if (!OpenAgain()) return;
      LOG(WARNING) << "the camera is back";
    }
  }

  // Returns why the device gives no more; OK when stopped.
  absl::Status Play() {
    std::optional<int64_t> zero_ns;  // Of the device's clock, in the machine's time.
    while (!stop_.HasBeenNotified()) {
      auto picture = device_->Next(kWait);
      if (!picture.ok()) return picture.status();
      if (!picture->has_value()) continue;
      const int64_t stamp_ns = 1000 * (*picture)->stamp_us;
      if (!zero_ns.has_value()) zero_ns = Now_ns() - stamp_ns;
      pairing_->Push((*picture)->side, {*zero_ns + stamp_ns, std::move((*picture)->image)});
    }
    return absl::OkStatus();
  }

  // Returns false when stopped.
  bool OpenAgain() {
    while (!stop_.WaitForNotificationWithTimeout(kBetweenStarts)) {
      absl::StatusOr<std::unique_ptr<OpenNiDevice>> device = OpenNiDevice::Open(options_);
      if (!device.ok()) continue;
      device_ = *std::move(device);
      return true;
    }
    return false;
  }

  const OpenNiOptions options_;
  const std::optional<bool> restarts_;
  PicturePairing* pairing_ = nullptr;
  std::unique_ptr<OpenNiDevice> device_;  // Keep's, once it runs.
  absl::Notification stop_;
  std::shared_ptr<const absl::Notification> kept_;  // Notified when the thread has left.
};

}  // namespace

std::unique_ptr<LiveCamera> MakeOpenNiCamera(std::unique_ptr<OpenNiDevice> device,
                                             const OpenNiOptions& options,
                                             std::optional<bool> restarts) {
  return std::make_unique<OpenNiCamera>(std::move(device), options, restarts);
}

}  // namespace corbslam::client_agent
