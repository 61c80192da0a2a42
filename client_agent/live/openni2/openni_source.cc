#include "client_agent/live/openni2/openni_source.h"

#include <glog/logging.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/live/live_options.h"
#include "client_agent/live/openni2/openni_camera.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_kinds.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr char kKind[] = "openni2";
// Depth and colour of these devices are up to half a frame apart where they can't be exposed
// together.
constexpr double kWithin_ms = 17;

OpenNiOptions OptionsOf(const std::string& place, const LiveSourceOptions& live, const Rig& rig) {
  OpenNiOptions options;
  if (place != "any") options.uri = place;
  const RigCamera& colour = rig.cameras[0];
  options.colour_px = {colour.width_px, colour.height_px};
  options.depth_px = options.colour_px;
  if (const auto& depth = rig.depth.camera; depth.has_value()) {
    options.depth_px = {depth->width_px, depth->height_px};
  }
  if (live.registers.has_value()) options.device_registers = false;
  options.rate_hz = rig.rate_hz;
  options.units_per_m = rig.depth.units_per_m;
  return options;
}

class OpenNiSettings : public KindSettings {
 public:
  explicit OpenNiSettings(std::string place) : place_(std::move(place)) {
    live_.pair_within_ms = kWithin_ms;
  }

  absl::string_view kind() const override { return kKind; }
  std::vector<absl::string_view> OptionNames() const override { return LiveOptionNames(); }
  absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                          absl::string_view value) const override {
    auto changed = std::make_shared<OpenNiSettings>(*this);
    RETURN_IF_ERROR(SetLiveOption(key, value, changed->live_));
    return changed;
  }
  absl::Status Validate() const override { return absl::OkStatus(); }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override {
    return FormatLiveOptions(live_);
  }
  uint64_t noise_seed() const override { return 1; }
  bool turned() const override { return false; }
  bool is_live() const override { return true; }
  bool trusts_calibration() const override { return live_.trust_calibration; }
  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return absl::InvalidArgumentError(
        absl::StrCat(kKind, ":", place_, " is a live camera: client_agent plays it"));
  }
  absl::StatusOr<std::unique_ptr<FrameStream>> OpenLive(
      const absl::Notification& /*stop*/) const override {
    ASSIGN_OR_RETURN(const Rig rig, ReadRig());
    OpenNiOptions options = OptionsOf(place_, live_, rig);
    ASSIGN_OR_RETURN(std::unique_ptr<OpenNiDevice> device, OpenNiDevice::Open(options));
    // Once it is known whether the device registers, it does so after it was unplugged too.
    if (!device->is_recording()) options.device_registers = device->registers();
    options.uri = device->uri();
    LiveSourceOptions live = live_;
    RETURN_IF_ERROR(DecideRegistration(rig, *device, live));
    return LiveStream::Open(rig, MakeOpenNiCamera(std::move(device), options, live_.restarts),
                            StreamOptions(absl::StrCat(kKind, ":", place_), live));
  }

  absl::Status CheckLive() const override {
    ASSIGN_OR_RETURN(const Rig rig, ReadRig());
    return LiveStream::Check(rig, StreamOptions(absl::StrCat(kKind, ":", place_), live_));
  }

 private:
  absl::StatusOr<Rig> ReadRig() const {
    ASSIGN_OR_RETURN(Rig rig, ReadLiveRig(kKind, live_));
    if (rig.kind == RigKind::kRgbd) return rig;
    return absl::InvalidArgumentError(
        absl::StrCat(live_.rig, ": is of a stereo pair, ", kKind, " gives RGB-D"));
  }

  // The device registers where it can, else the rig; where neither does somebody must say that it
  // is done already.
  absl::Status DecideRegistration(const Rig& rig, const OpenNiDevice& device,
                                  LiveSourceOptions& live) const {
    if (device.registers()) {
      if (live.registers.value_or(false)) {
        return absl::InvalidArgumentError(
            absl::StrCat(device.uri(), " was recorded registered: leave register=1 out"));
      }
      LOG(INFO) << device.uri() << ": depth is registered by the device";
      live.registers = false;
      return absl::OkStatus();
    }
    if (live.registers.has_value() || rig.depth.camera.has_value()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat(device.uri(),
                     ": the device does not register depth to its picture, and the rig doesn't say "
                     "how (depth.camera, depth.colour_from_depth; docs/rig.md); ?register=0 takes "
                     "depth as it comes"));
  }

  const std::string place_;
  LiveSourceOptions live_;
};

}  // namespace

void RegisterOpenNiSources() {
  RegisterSourceKind(
      {kKind, "openni2:any", [](absl::string_view place) -> absl::StatusOr<SharedKindSettings> {
         return std::make_shared<OpenNiSettings>(std::string(place));
       }});
}

}  // namespace corbslam::client_agent
