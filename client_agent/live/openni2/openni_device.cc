#include "client_agent/live/openni2/openni_device.h"

#include <glog/logging.h>

#include <opencv2/core.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "client_agent/live/openni2/openni_picture.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using openni::OpenNI;

std::string LastWords() { return std::string(absl::StripSuffix(OpenNI::getExtendedError(), "\n")); }

absl::Status InitialiseOnce() {
  static const auto* const status = new absl::Status([] {
    if (OpenNI::initialize() == openni::STATUS_OK) return absl::OkStatus();
    return absl::UnavailableError(absl::StrCat("OpenNI 2 does not start: ", LastWords()));
  }());
  return *status;
}

}  // namespace

// Is told by OpenNI when a device goes.
class OpenNiDevice::Gone : public OpenNI::DeviceDisconnectedListener {
 public:
  explicit Gone(std::string uri) : uri_(std::move(uri)) {
    OpenNI::addDeviceDisconnectedListener(this);
  }
  ~Gone() override { OpenNI::removeDeviceDisconnectedListener(this); }
  void onDeviceDisconnected(const openni::DeviceInfo* device) override {
    if (uri_ == device->getUri()) gone_ = true;
  }
  bool gone() const { return gone_; }

 private:
  const std::string uri_;
  std::atomic<bool> gone_ = false;
};

absl::StatusOr<std::unique_ptr<OpenNiDevice>> OpenNiDevice::Open(const OpenNiOptions& options) {
  RETURN_IF_ERROR(InitialiseOnce());
  std::unique_ptr<OpenNiDevice> device(new OpenNiDevice);
  const char* const uri = options.uri.empty() ? openni::ANY_DEVICE : options.uri.c_str();
  if (device->device_.open(uri) != openni::STATUS_OK) {
    return absl::NotFoundError(
        absl::StrCat("OpenNI 2 opens no ",
                     options.uri.empty() ? std::string("device: is one plugged in, and may this "
                                                       "user read it?")
                                         : options.uri,
                     " (", LastWords(), ")"));
  }
  RETURN_IF_ERROR(device->Start(options));
  return device;
}

absl::Status OpenNiDevice::Start(const OpenNiOptions& options) {
  uri_ = device_.getDeviceInfo().getUri();
  gone_ = std::make_unique<Gone>(uri_);
  RETURN_IF_ERROR(Register(options));
  RETURN_IF_ERROR(SetUp(colour_, openni::SENSOR_COLOR, options.colour_px, options));
  RETURN_IF_ERROR(SetUp(depth_, openni::SENSOR_DEPTH,
                        registers_ ? options.colour_px : options.depth_px, options));
  RETURN_IF_ERROR(CheckUnits(options.units_per_m));
  // Where both are exposed together; devices that can't say so.
  device_.setDepthColorSyncEnabled(true);
  if (openni::PlaybackControl* const playback = device_.getPlaybackControl()) {
    playback->setRepeatEnabled(false);
  }
  if (colour_.start() != openni::STATUS_OK || depth_.start() != openni::STATUS_OK) {
    return absl::UnavailableError(absl::StrCat(uri_, " does not start: ", LastWords()));
  }
  return absl::OkStatus();
}

absl::Status OpenNiDevice::Register(const OpenNiOptions& options) {
  constexpr auto kRegistered = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  if (device_.isFile()) {
    registers_ = device_.getImageRegistrationMode() == kRegistered;
    return absl::OkStatus();
  }
  const bool can = device_.isImageRegistrationModeSupported(kRegistered);
  if (!options.device_registers.value_or(can)) {
    device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_OFF);
    return absl::OkStatus();
  }
  if (device_.setImageRegistrationMode(kRegistered) == openni::STATUS_OK) {
    registers_ = true;
    return absl::OkStatus();
  }
  return absl::UnavailableError(
      absl::StrCat(uri_, " does not register depth to colour: ", LastWords()));
}

absl::Status OpenNiDevice::SetUp(openni::VideoStream& stream, openni::SensorType type,
                                 const cv::Size& size, const OpenNiOptions& options) {
  const bool is_depth = type == openni::SENSOR_DEPTH;
  const char* const what = is_depth ? "depth" : "colour";
  if (stream.create(device_, type) != openni::STATUS_OK) {
    return absl::InvalidArgumentError(absl::StrCat(uri_, " has no ", what, ": ", LastWords()));
  }
  const openni::VideoMode* const mode = ChooseMode(stream.getSensorInfo(), size, options.rate_hz);
  if (mode == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(uri_, " gives no ", what, " of ", size.width, "x", size.height,
                     " in a format that is known, which the rig says; it has ",
                     ListModes(stream.getSensorInfo()), ": give the rig of one of these"));
  }
  // A recording has one mode, which can't be set.
  if (!device_.isFile() && stream.setVideoMode(*mode) != openni::STATUS_OK) {
    return absl::UnavailableError(
        absl::StrCat(uri_, " refuses ", what, " of ", DescribeMode(*mode), ": ", LastWords()));
  }
  stream.setMirroringEnabled(false);
  flips_[static_cast<size_t>(is_depth ? LiveSide::kSecond : LiveSide::kFirst)] =
      stream.getMirroringEnabled();
  return absl::OkStatus();
}

absl::Status OpenNiDevice::CheckUnits(double units_per_m) const {
  const bool is_fine = depth_.getVideoMode().getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM;
  const double has = is_fine ? 10000 : 1000;
  if (has == units_per_m) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(uri_, " gives depth in ", has,
                                                 " units a metre, the rig says ", units_per_m,
                                                 ": set depth.units_per_m"));
}

OpenNiDevice::~OpenNiDevice() {
  colour_.destroy();
  depth_.destroy();
  gone_.reset();
  device_.close();
}

bool OpenNiDevice::IsAtEnd() {
  openni::PlaybackControl* const playback = device_.getPlaybackControl();
  return playback != nullptr && last_index_[0] >= playback->getNumberOfFrames(colour_) &&
         last_index_[1] >= playback->getNumberOfFrames(depth_);
}

absl::StatusOr<std::optional<OpenNiDevice::Picture>> OpenNiDevice::Next(absl::Duration wait) {
  openni::VideoStream* streams[] = {&colour_, &depth_};
  int ready = 0;
  const openni::Status status = OpenNI::waitForAnyStream(
      streams, 2, &ready, static_cast<int>(absl::ToInt64Milliseconds(wait)));
  if (gone_->gone()) return absl::UnavailableError(absl::StrCat(uri_, " was unplugged"));
  if (status == openni::STATUS_TIME_OUT) {
    if (IsAtEnd()) return absl::OutOfRangeError("the recording's end");
    return std::nullopt;
  }
  openni::VideoFrameRef frame;
  if (status != openni::STATUS_OK || streams[ready]->readFrame(&frame) != openni::STATUS_OK) {
    return absl::UnavailableError(absl::StrCat(uri_, ": ", LastWords()));
  }
  Picture picture{ready == 0 ? LiveSide::kFirst : LiveSide::kSecond,
                  static_cast<int64_t>(frame.getTimestamp()),
                  {}};
  last_index_[ready] = frame.getFrameIndex();
  picture.image = ready == 0 ? ToGrey(frame) : ToDepth(frame);
  if (flips_[ready]) cv::flip(picture.image, picture.image, 1);
  return picture;
}

}  // namespace corbslam::client_agent
