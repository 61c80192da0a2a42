#include "client_agent/live/push/push_camera.h"

#include <glog/logging.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/push_client/wire.h"
#include "client_agent/source/rig/rig_file.h"
#include "slam/camera/recorded_camera.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kLongestWait_ms = 100;
constexpr size_t kMostPoses =
    64;  // Between two steps, in which the driver's thread had no processor.

void Wake(const UniqueFd& fd) {
  const uint64_t one = 1;
  // It fails only where somebody is to be woken already.
  if (write(fd.get(), &one, sizeof(one)) < 0) return;
}

// Returns CLOCK_MONOTONIC.
int64_t Now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Calm(const UniqueFd& fd) {
  uint64_t count = 0;
  if (read(fd.get(), &count, sizeof(count)) < 0) return;
}

}  // namespace

absl::StatusOr<std::unique_ptr<PushCamera>> PushCamera::Open(const PushCameraOptions& options) {
  UniqueFd wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (wake.get() < 0) return absl::ResourceExhaustedError("no eventfd");
  ASSIGN_OR_RETURN(UnixListener listener, UnixListener::Listen(options.path));
  std::unique_ptr<PushCamera> camera(new PushCamera(options, std::move(listener), std::move(wake)));
  if (options.rig.has_value()) RETURN_IF_ERROR(camera->UseRig(*options.rig));
  return camera;
}

absl::Status PushCamera::UseRig(const Rig& rig) {
  ASSIGN_OR_RETURN(const SensorCalibration calibration, CalibrationOf(rig));
  ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(calibration));
  ASSIGN_OR_RETURN(camera_from_recorded_, CameraFromWanted(recorded, PosesOf::kRecordedCamera));
  rig_ = rig;
  return absl::OkStatus();
}

absl::StatusOr<Rig> PushCamera::AwaitRig(const absl::Notification& stop) {
  if (!rig_.has_value()) {
    LOG(INFO) << "waiting for a driver at " << options_.path
              << " that says the rig of its cameras (--rig FILE makes that unnecessary)";
  }
  while (!rig_.has_value()) {
    if (stop.HasBeenNotified()) {
      return absl::CancelledError(absl::StrCat("push:", options_.path, ": no driver came"));
    }
    Step();
  }
  return *rig_;
}

absl::Status PushCamera::Start(PicturePairing& pairing) {
  pairing_ = &pairing;
  if (!driver_.has_value()) LOG(INFO) << "waiting for a driver at " << options_.path;
  thread_ = StartThread("push socket", [this] {
    while (!stop_.HasBeenNotified()) Step();
  });
  return absl::OkStatus();
}

void PushCamera::Stop() {
  if (!stop_.HasBeenNotified()) stop_.Notify();
  Wake(wake_);
  if (thread_.joinable()) thread_.join();
}

void PushCamera::Step() {
  pollfd waiting[3] = {{wake_.get(), POLLIN, 0}, {listener_.fd(), POLLIN, 0}, {-1, POLLIN, 0}};
  if (driver_.has_value()) {
    waiting[2].fd = driver_->fd();
    if (driver_->wants_to_write()) waiting[2].events |= POLLOUT;
  }
  if (poll(waiting, 3, kLongestWait_ms) < 0) return;
  if (waiting[0].revents != 0) Calm(wake_);
  TakePoses();
  if (driver_.has_value()) {
    const auto heard = static_cast<unsigned>(waiting[2].revents);
    const absl::Status served = ServeDriver((heard & ~unsigned{POLLOUT}) != 0,
                                            (heard & (unsigned{POLLHUP} | POLLERR)) != 0);
    if (!served.ok()) {
      LOG(WARNING) << "the driver " << driver_->who()
                   << (absl::IsUnavailable(served) ? " went away: " : " was refused: ")
                   << served.message() << "; waiting for one at " << options_.path;
      driver_.reset();
      newest_ns_ = -1;
      newest_imu_ns_ = -1;
      imu_.Clear();
    }
  }
  if (waiting[1].revents != 0) AcceptOne();
}

absl::Status PushCamera::ServeDriver(bool readable, bool went) {
  if (readable) RETURN_IF_ERROR(driver_->Read());
  // Reading ends with an error at the latest when nothing is left.
  while (went) RETURN_IF_ERROR(driver_->Read());
  RETURN_IF_ERROR(driver_->CheckHello(absl::Now()));
  driver_->Write();
  return absl::OkStatus();
}

void PushCamera::AcceptOne() {
  std::optional<UniqueFd> socket = listener_.Accept();
  if (!socket.has_value()) return;
  if (!driver_.has_value()) {
    driver_.emplace(*std::move(socket), static_cast<PushHost&>(*this));
    return;
  }
  const std::string why =
      absl::StrCat("another driver is connected, ", driver_->who(), ": there is one at a time");
  LOG(WARNING) << PeerOf(socket->get()) << " was turned away: " << why;
  TurnAway(*std::move(socket), why);
}

absl::Status PushCamera::OnHello(const PushHello& hello) {
  if (!options_.rig.has_value()) {
    RETURN_IF_ERROR(UseDriversRig(hello));
  } else if (!hello.rig_text.empty() && !std::exchange(rig_is_told_, true)) {
    LOG(INFO) << "the driver's rig is not used: this robot was given one";
  }
  return CheckPictures(hello.layout, *rig_);
}

absl::Status PushCamera::UseDriversRig(const PushHello& hello) {
  if (hello.rig_text.empty()) {
    return absl::InvalidArgumentError(
        "rig: the hello says none, and the robot was given none (--rig FILE)");
  }
  constexpr char kFrom[] = "the driver's rig";
  ASSIGN_OR_RETURN(const Rig rig, ReadRigText(hello.rig_text, kFrom));
  RETURN_IF_ERROR(CheckPictures(hello.layout, rig));
  if (rig_.has_value()) {
    if (FormatRig(rig, "") == FormatRig(*rig_, "")) return absl::OkStatus();
    return absl::InvalidArgumentError(
        "rig: is another one than that with which this robot began: start the robot anew");
  }
  ASSIGN_OR_RETURN(const SourceFindings findings, JudgeRig(rig, kFrom, options_.trust_calibration));
  for (const SourceFinding& finding : findings) LOG(WARNING) << finding.text;
  return UseRig(rig);
}

absl::Status PushCamera::CheckClock(int64_t timestamp_ns) {
  const int64_t now_ns = Now_ns();
  if (timestamp_ns <= now_ns || timestamp_ns - now_ns <= push_wire::kMostAhead_ns) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "timestamp_ns is ", timestamp_ns, ", which is more than a minute ahead of CLOCK_MONOTONIC, ",
      now_ns, ": is it of another clock?"));
}

absl::Status PushCamera::OnImu(const ImuSamples& samples) {
  if (!takes_imu()) {
    return absl::InvalidArgumentError(
        "samples of an IMU came, and the rig has no block imu: that says where it sits "
        "(docs/rig.md)");
  }
  if (samples.front().timestamp_ns <= newest_imu_ns_) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a sample's timestamp_ns is ", samples.front().timestamp_ns, ", the one before has ",
        newest_imu_ns_, ": times must grow (CLOCK_MONOTONIC)"));
  }
  RETURN_IF_ERROR(CheckClock(samples.back().timestamp_ns));
  newest_imu_ns_ = samples.back().timestamp_ns;
  imu_.Add(samples);
  return absl::OkStatus();
}

absl::Status PushCamera::OnFrame(int64_t timestamp_ns, cv::Mat first, cv::Mat second) {
  if (timestamp_ns <= newest_ns_) {
    return absl::InvalidArgumentError(absl::StrCat("timestamp_ns is ", timestamp_ns,
                                                   ", the frame before has ", newest_ns_,
                                                   ": times must grow (CLOCK_MONOTONIC)"));
  }
  RETURN_IF_ERROR(CheckClock(timestamp_ns));
  newest_ns_ = timestamp_ns;
  // A driver that said the rig and went before the robot began.
  if (pairing_ == nullptr) return absl::OkStatus();
  pairing_->Push(LiveSide::kFirst, {timestamp_ns, std::move(first)});
  if (!second.empty()) pairing_->Push(LiveSide::kSecond, {timestamp_ns, std::move(second)});
  return absl::OkStatus();
}

void PushCamera::OnPose(const FramePose& pose) {
  FramePose of_recorded = pose;
  if (pose.local_from_camera.has_value() && camera_from_recorded_.has_value()) {
    of_recorded.local_from_camera = *pose.local_from_camera * *camera_from_recorded_;
  }
  {
    const absl::MutexLock lock(&mutex_);
    if (poses_.size() < kMostPoses) poses_.push_back(FormatPose(of_recorded));
  }
  Wake(wake_);
}

void PushCamera::TakePoses() {
  std::vector<std::string> poses;
  {
    const absl::MutexLock lock(&mutex_);
    poses.swap(poses_);
  }
  if (!driver_.has_value() || !driver_->is_welcome()) return;
  for (std::string& pose : poses) driver_->AddPose(std::move(pose));
}

}  // namespace corbslam::client_agent
