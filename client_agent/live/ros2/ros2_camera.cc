#include "client_agent/live/ros2/ros2_camera.h"

#include <glog/logging.h>
#include <ros2_types.h>

#include <cmath>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "client_agent/live/ros2/ros2_messages.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using ImageMessage = sensor_msgs_msg_dds__Image_;
using CompressedMessage = sensor_msgs_msg_dds__CompressedImage_;

constexpr absl::Duration kLook = absl::Milliseconds(100);
constexpr uint64_t kLogOneOf = 300;

// Floats are metres. Of 16 bits 0 is no depth.
cv::Mat InUnits(const cv::Mat& metres, double units_per_m) {
  cv::Mat depth(metres.size(), CV_16UC1);
  for (int y = 0; y < metres.rows; ++y) {
    const auto* const from = metres.ptr<float>(y);
    auto* const to = depth.ptr<uint16_t>(y);
    for (int x = 0; x < metres.cols; ++x) {
      const double units = std::round(static_cast<double>(from[x]) * units_per_m);
      // False for NaN, too. 65535 means no depth to many drivers.
      to[x] = units > 0 && units < 65'535 ? static_cast<uint16_t>(units) : uint16_t{0};
    }
  }
  return depth;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Ros2Camera>> Ros2Camera::Open(std::shared_ptr<Ros2Context> context,
                                                             const Ros2CameraOptions& options) {
  std::unique_ptr<Ros2Camera> camera(new Ros2Camera(std::move(context), options));
  RETURN_IF_ERROR(camera->SubscribeAll());
  return camera;
}

absl::Status Ros2Camera::SubscribeAll() {
  const Ros2Settings& settings = context_->settings();
  for (const size_t side : {size_t{0}, size_t{1}}) {
    RETURN_IF_ERROR(SubscribePictures(side));
    ASSIGN_OR_RETURN(
        infos_[side],
        context_->node().Subscribe(
            DdsTopic(settings.infos[side].topic), sensor_msgs_msg_dds__CameraInfo__desc,
            settings.infos[side].qos, [this, side](const void* sample) {
              RosCameraInfo info =
                  FromRos2(*static_cast<const sensor_msgs_msg_dds__CameraInfo_*>(sample));
              const absl::MutexLock lock(&mutex_);
              if (!sides_[side].info.has_value()) sides_[side].info = std::move(info);
            }));
  }
  if (!settings.uses_imu) return absl::OkStatus();
  ASSIGN_OR_RETURN(
      imu_topic_,
      context_->node().Subscribe(DdsTopic(settings.imu.topic), sensor_msgs_msg_dds__Imu__desc,
                                 settings.imu.qos, [this](const void* sample) { OnImu(sample); }));
  return absl::OkStatus();
}

absl::Status Ros2Camera::SubscribePictures(size_t side) {
  const Ros2Settings& settings = context_->settings();
  const Ros2Input& input = settings.images[side];
  const bool is_compressed =
      side == 1 && settings.is_rgbd ? settings.depth_is_compressed : settings.is_compressed;
  const auto take = [this, side, is_compressed](const void* sample) {
    if (is_compressed) {
      OnPicture(side, *static_cast<const CompressedMessage*>(sample));
    } else {
      OnPicture(side, *static_cast<const ImageMessage*>(sample));
    }
  };
  ASSIGN_OR_RETURN(images_[side], context_->node().Subscribe(
                                      DdsTopic(input.topic),
                                      is_compressed ? sensor_msgs_msg_dds__CompressedImage__desc
                                                    : sensor_msgs_msg_dds__Image__desc,
                                      input.qos, take));
  return absl::OkStatus();
}

template <typename Picture>
absl::StatusOr<cv::Mat> Ros2Camera::Decode(size_t side, const Picture& picture) {
  if (side == 0 || !context_->settings().is_rgbd) {
    ASSIGN_OR_RETURN(const cv::Mat grey, GreyOf(picture));
    return grey_.ToEightBits(grey);
  }
  ASSIGN_OR_RETURN(cv::Mat depth, DepthOf(picture));
  const double units_per_m =
      options_.rig.has_value() ? options_.rig->depth.units_per_m : RigDepth().units_per_m;
  return depth.type() == CV_32FC1 ? InUnits(depth, units_per_m) : depth;
}

template <typename Message>
void Ros2Camera::OnPicture(size_t side, const Message& message) {
  const auto picture = FromRos2(message);
  bool is_wanted = false;
  {
    const absl::MutexLock lock(&mutex_);
    Ros2Side& known = sides_[side];
    if (!known.form.has_value()) {
      known.form = FormOf(picture);
      known.frame_id = picture.header.frame_id;
    }
    is_wanted = pairing_ != nullptr;
  }
  if (!is_wanted) return;
  if (picture.header.stamp_ns <= 0) {
    return LeaveOut(side, "its header has no time: have the driver stamp its pictures");
  }
  absl::StatusOr<cv::Mat> image = Decode(side, picture);
  if (!image.ok()) return LeaveOut(side, std::string(image.status().message()));
  const absl::MutexLock lock(&mutex_);
  if (pairing_ == nullptr) return;
  pairing_->Push(side == 0 ? LiveSide::kFirst : LiveSide::kSecond,
                 {picture.header.stamp_ns, *std::move(image)});
}

void Ros2Camera::LeaveOut(size_t side, const std::string& why) {
  const absl::MutexLock lock(&mutex_);
  if (left_out_[side]++ % kLogOneOf != 0) return;
  const std::string text =
      absl::StrCat(context_->settings().images[side].topic, ": a picture is left out: ", why);
  LOG(WARNING) << text << " (" << left_out_[side] << " so far)";
  Ros2CameraState state = context_->camera();
  state.problem = text;
  context_->SetCamera(std::move(state));
}

void Ros2Camera::OnImu(const void* sample) {
  const auto& message = *static_cast<const sensor_msgs_msg_dds__Imu_*>(sample);
  const std::optional<ImuSample> measured = FromRos2(message);
  if (!measured.has_value()) return;
  const std::string frame = FromRos2(message.header).frame_id;
  const absl::MutexLock lock(&mutex_);
  if (imu_frame_.empty()) imu_frame_ = frame;
  // Samples of another frame are another IMU's; best effort may bring them twice or out of order.
  if (frame != imu_frame_ || measured->timestamp_ns <= newest_imu_ns_) return;
  newest_imu_ns_ = measured->timestamp_ns;
  if (pairing_ != nullptr) imu_.Add({*measured});
}

absl::Status Ros2Camera::Start(PicturePairing& pairing) {
  const absl::MutexLock lock(&mutex_);
  pairing_ = &pairing;
  return absl::OkStatus();
}

void Ros2Camera::Stop() {
  // Handlers hold on to this camera.
  context_->node().Stop();
  const absl::MutexLock lock(&mutex_);
  pairing_ = nullptr;
}

std::string Ros2Camera::CameraFrame() const {
  const std::string& named = context_->settings().camera_frame;
  const absl::MutexLock lock(&mutex_);
  return named.empty() ? sides_[0].frame_id : named;
}

std::vector<std::string> Ros2Camera::MissingMessages() const {
  const Ros2Settings& settings = context_->settings();
  Ros2Side sides[2];
  bool has_imu = true;
  {
    const absl::MutexLock lock(&mutex_);
    sides[0] = sides_[0];
    sides[1] = sides_[1];
    has_imu = imu_topic_ == nullptr || newest_imu_ns_ != INT64_MIN;
  }
  std::vector<std::string> missing;
  const auto why = [&](const Ros2Subscription& topic, const std::string& name) {
    const std::string nothing = context_->graph().WhyNothing(topic, name);
    missing.push_back(nothing.empty() ? absl::StrCat(name, " has just come") : nothing);
  };
  for (const size_t side : {size_t{0}, size_t{1}}) {
    if (!sides[side].form.has_value()) why(*images_[side], settings.images[side].name);
  }
  for (const size_t side : {size_t{0}, size_t{1}}) {
    const bool is_depth = side == 1 && settings.is_rgbd;
    const bool is_needed = !options_.rig.has_value() &&
                           (!is_depth || !IsRegistered(settings, sides, options_.registers));
    if (is_needed && !sides[side].info.has_value()) {
      why(*infos_[side], settings.infos[side].name);
      absl::StrAppend(&missing.back(), "; or give a rig file (--rig)");
    }
  }
  if (!has_imu) why(*imu_topic_, settings.imu.name);
  return missing;
}

absl::Status Ros2Camera::PlaceBase(const std::string& camera_frame, Rig& rig) const {
  const Ros2Settings& settings = context_->settings();
  if (camera_frame.empty()) {
    return absl::NotFoundError(
        absl::StrCat("the headers of ", settings.images[0].topic,
                     " name no frame: say it by -p camera_optical_frame:=FRAME"));
  }
  if (settings.base_frame == camera_frame) {
    rig.body_from_camera = Rigid3d::Identity();
    return absl::OkStatus();
  }
  const absl::StatusOr<Rigid3d> base_from_camera =
      context_->frames().TargetFromSource(settings.base_frame, camera_frame);
  if (base_from_camera.ok()) {
    rig.body_from_camera = *base_from_camera;
  } else if (!rig.body_from_camera.has_value()) {
    return absl::NotFoundError(absl::StrCat(
        base_from_camera.status().message(),
        ": publish where the camera sits (robot_state_publisher, static_transform_publisher), say "
        "body_from_camera in a rig file, or -p base_frame:=",
        camera_frame));
  }
  return absl::OkStatus();
}

absl::Status Ros2Camera::PlaceImu(const std::string& camera_frame, Rig& rig) const {
  const Ros2Settings& settings = context_->settings();
  if (!settings.uses_imu) {
    rig.imu.reset();
    return absl::OkStatus();
  }
  if (rig.imu.has_value()) return absl::OkStatus();
  std::string imu_frame = settings.imu_frame;
  if (imu_frame.empty()) {
    const absl::MutexLock lock(&mutex_);
    imu_frame = imu_frame_;
  }
  const absl::StatusOr<Rigid3d> imu_from_camera =
      context_->frames().TargetFromSource(imu_frame, camera_frame);
  if (!imu_from_camera.ok()) {
    return absl::NotFoundError(absl::StrCat(
        imu_from_camera.status().message(),
        ": publish where the IMU sits, give a rig file with imu:, or -p enable_imu_fusion:=false"));
  }
  rig.imu.emplace();
  rig.imu->imu_from_camera = *imu_from_camera;
  return absl::OkStatus();
}

absl::StatusOr<Rig> Ros2Camera::MakeRig() const {
  const std::string camera_frame = CameraFrame();
  Rig rig;
  if (options_.rig.has_value()) {
    rig = *options_.rig;
    const RigKind kind = context_->settings().is_rgbd ? RigKind::kRgbd : RigKind::kStereo;
    if (rig.kind != kind) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the rig file is of ", rig.kind == RigKind::kRgbd ? "an RGB-D camera" : "a stereo pair",
          ": -p tracking_mode:=", rig.kind == RigKind::kRgbd ? "rgbd" : "stereo"));
    }
  }
  RETURN_IF_ERROR(PlaceBase(camera_frame, rig));
  RETURN_IF_ERROR(PlaceImu(camera_frame, rig));
  if (options_.rig.has_value()) return rig;
  Ros2Side sides[2];
  {
    const absl::MutexLock lock(&mutex_);
    sides[0] = sides_[0];
    sides[1] = sides_[1];
  }
  // It logs what it finds, and is therefore the last that may fail.
  ASSIGN_OR_RETURN(Rig cameras,
                   MakeRos2Rig(context_->settings(), sides, context_->frames().FixedTree(),
                               options_.registers, options_.trust_calibration));
  cameras.body_from_camera = rig.body_from_camera;
  cameras.imu = rig.imu;
  return cameras;
}

void Ros2Camera::TellContext(const Rig& rig) {
  Ros2CameraState state;
  state.camera_frame = CameraFrame();
  const std::string& base = context_->settings().base_frame;
  state.base_is_of_rig = rig.body_from_camera.has_value() && base != state.camera_frame &&
                         !context_->frames().TargetFromSource(base, state.camera_frame).ok();
  state.images[0] = images_[0];
  state.images[1] = images_[1];
  context_->SetCamera(std::move(state));
}

absl::StatusOr<Rig> Ros2Camera::AwaitRig(const absl::Notification& stop) {
  const absl::Time began = absl::Now();
  absl::Time tell = began + kToldFirst;
  absl::Time had_all = absl::InfiniteFuture();
  for (;;) {
    std::vector<std::string> missing = MissingMessages();
    if (missing.empty()) {
      had_all = std::min(had_all, absl::Now());
      absl::StatusOr<Rig> rig = MakeRig();
      if (rig.ok()) {
        TellContext(*rig);
        return rig;
      }
      // Somebody may still publish on /tf_static.
      if (!absl::IsNotFound(rig.status()) && absl::Now() > had_all + kPatience) {
        return rig.status();
      }
      missing.emplace_back(rig.status().message());
    }
    if (absl::Now() >= tell) {
      LOG(WARNING) << "waits for the camera: " << absl::StrJoin(missing, "; ");
      Ros2CameraState state = context_->camera();
      state.problem = absl::StrJoin(missing, "; ");
      context_->SetCamera(std::move(state));
      tell = absl::Now() + kToldAgain;
    }
    if (stop.WaitForNotificationWithTimeout(kLook)) {
      return absl::CancelledError("stopped while it waited for the camera");
    }
  }
}

}  // namespace corbslam::client_agent
