// A driver of OpenNI 2 whose device is made up, so that sources can be tested without one: depth
// and colour of 160x120 pixels, thirty a second. It is mirrored until somebody turns that off;
// registers depth where the variable CORBSLAM_MADE_UP_REGISTERS is 1; and is unplugged while the
// file that CORBSLAM_MADE_UP_UNPLUGGED names is there.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>

#include "Driver/OniDriverAPI.h"

// The header's macro below takes them from a library that isn't installed with it.
#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete pointer

namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kFps = 30;
constexpr auto kInterval = std::chrono::microseconds(1'000'000 / kFps);

OniVideoMode ModeOf(OniSensorType type) {
  return {type == ONI_SENSOR_DEPTH ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888, kWidth,
          kHeight, kFps};
}

class Stream : public oni::driver::StreamBase {
 public:
  explicit Stream(OniSensorType type) : type_(type) {}
  ~Stream() override { stop(); }

  OniStatus start() override {
    stopping_ = false;
    thread_ = std::thread([this] { Run(); });
    return ONI_STATUS_OK;
  }
  void stop() override {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }
  OniBool isPropertySupported(int property) override {
    return property == ONI_STREAM_PROPERTY_VIDEO_MODE ||
           property == ONI_STREAM_PROPERTY_MIRRORING || property == ONI_STREAM_PROPERTY_CROPPING;
  }
  OniStatus getProperty(int property, void* data, int* size) override {
    if (property == ONI_STREAM_PROPERTY_VIDEO_MODE) {
      const OniVideoMode mode = ModeOf(type_);
      std::memcpy(data, &mode, sizeof(mode));
      *size = sizeof(mode);
      return ONI_STATUS_OK;
    }
    if (property == ONI_STREAM_PROPERTY_CROPPING) {  // Recordings play with it only.
      const OniCropping none = {};
      std::memcpy(data, &none, sizeof(none));
      *size = sizeof(none);
      return ONI_STATUS_OK;
    }
    if (property != ONI_STREAM_PROPERTY_MIRRORING) return ONI_STATUS_NOT_SUPPORTED;
    const OniBool mirrored = mirrored_ ? TRUE : FALSE;
    std::memcpy(data, &mirrored, sizeof(mirrored));
    *size = sizeof(mirrored);
    return ONI_STATUS_OK;
  }
  OniStatus setProperty(int property, const void* data, int) override {
    if (property == ONI_STREAM_PROPERTY_VIDEO_MODE) return ONI_STATUS_OK;
    if (property != ONI_STREAM_PROPERTY_MIRRORING) return ONI_STATUS_NOT_SUPPORTED;
    mirrored_ = *static_cast<const OniBool*>(data) != FALSE;
    return ONI_STATUS_OK;
  }

 private:
  void Run() {
    for (int i = 1; !stopping_; ++i) {
      std::this_thread::sleep_for(kInterval);
      OniFrame* const frame = getServices().acquireFrame();
      if (frame == nullptr) continue;
      Fill(i, *frame);
      raiseNewFrame(frame);
      getServices().releaseFrame(frame);
    }
  }

  // Depth is 1000 mm plus the column, grey the column, both as they are without a mirror.
  void Fill(int index, OniFrame& frame) const {
    const int bytes = type_ == ONI_SENSOR_DEPTH ? 2 : 3;
    frame.sensorType = type_;
    frame.frameIndex = index;
    frame.timestamp = 7'000'000 + static_cast<uint64_t>(index) * kInterval.count();
    frame.width = kWidth;
    frame.height = kHeight;
    frame.videoMode = ModeOf(type_);
    frame.croppingEnabled = FALSE;
    frame.cropOriginX = frame.cropOriginY = 0;
    frame.stride = kWidth * bytes;
    frame.dataSize = frame.stride * kHeight;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const int column = mirrored_ ? kWidth - 1 - x : x;
        auto* const at = static_cast<uint8_t*>(frame.data) + y * frame.stride + x * bytes;
        if (type_ == ONI_SENSOR_DEPTH) {
          const auto depth = static_cast<uint16_t>(1000 + column);
          std::memcpy(at, &depth, sizeof(depth));
        } else {
          std::memset(at, column, 3);
        }
      }
    }
  }

  const OniSensorType type_;
  std::atomic<bool> mirrored_ = true;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

class MadeUpDevice : public oni::driver::DeviceBase {
 public:
  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_;
    *count = 2;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType type) override { return new Stream(type); }
  void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || CanRegister();
  }
  OniBool isPropertySupported(int property) override {
    return property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
  }
  OniStatus getProperty(int property, void* data, int* size) override {
    if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(data, &registration_, sizeof(registration_));
    *size = sizeof(registration_);
    return ONI_STATUS_OK;
  }
  OniStatus setProperty(int property, const void* data, int) override {
    if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    registration_ = *static_cast<const OniImageRegistrationMode*>(data);
    return ONI_STATUS_OK;
  }

 private:
  static bool CanRegister() {
    const char* const registers = std::getenv("CORBSLAM_MADE_UP_REGISTERS");
    return registers != nullptr && std::strcmp(registers, "1") == 0;
  }

  OniVideoMode modes_[2] = {ModeOf(ONI_SENSOR_DEPTH), ModeOf(ONI_SENSOR_COLOR)};
  OniSensorInfo sensors_[2] = {{ONI_SENSOR_DEPTH, 1, &modes_[0]},
                               {ONI_SENSOR_COLOR, 1, &modes_[1]}};
  OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
};

class MadeUpDriver : public oni::driver::DriverBase {
 public:
  explicit MadeUpDriver(OniDriverServices* services) : DriverBase(services) {
    std::strcpy(info_.uri, "made-up://0");
    std::strcpy(info_.vendor, "nobody");
    std::strcpy(info_.name, "made up");
  }

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    deviceConnected(&info_);
    thread_ = std::thread([this] { Watch(); });
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char*, const char*) override {
    return new MadeUpDevice;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void Watch() {
    bool is_plugged = true;
    while (!stopping_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      const char* const file = std::getenv("CORBSLAM_MADE_UP_UNPLUGGED");
      std::error_code ignored;
      const bool plugged = file == nullptr || !std::filesystem::exists(file, ignored);
      if (plugged == is_plugged) continue;
      is_plugged = plugged;
      plugged ? deviceConnected(&info_) : deviceDisconnected(&info_);
    }
  }

  OniDeviceInfo info_ = {};
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace

ONI_EXPORT_DRIVER(MadeUpDriver);
