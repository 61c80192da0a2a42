#include "client_agent/live/ros2/ros2_source.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/live/live_options.h"
#include "client_agent/live/ros2/ros2_camera.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_kinds.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

class Ros2SourceSettings : public KindSettings {
 public:
  explicit Ros2SourceSettings(std::shared_ptr<Ros2Context> context)
      : context_(std::move(context)) {}

  absl::string_view kind() const override { return "ros2"; }
  std::vector<absl::string_view> OptionNames() const override {
    return {"rig", "register", "trust_calibration"};
  }
  absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                          absl::string_view value) const override {
    auto changed = std::make_shared<Ros2SourceSettings>(*this);
    RETURN_IF_ERROR(SetLiveOption(key, value, changed->options_));
    return changed;
  }
  absl::Status Validate() const override { return absl::OkStatus(); }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override {
    return FormatLiveOptions(options_);
  }
  uint64_t noise_seed() const override { return 1; }
  bool turned() const override { return false; }
  bool is_live() const override { return true; }
  bool trusts_calibration() const override { return options_.trust_calibration; }

  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return absl::InvalidArgumentError(
        "ros2: is a live camera, whose frames nobody can list; bag: plays what was recorded");
  }
  absl::StatusOr<std::unique_ptr<FrameStream>> OpenLive(
      const absl::Notification& stop) const override {
    Ros2CameraOptions options{std::nullopt, options_.registers, options_.trust_calibration};
    ASSIGN_OR_RETURN(options.rig, ReadRig());
    RETURN_IF_ERROR(context_->Begin());
    ASSIGN_OR_RETURN(std::unique_ptr<Ros2Camera> camera, Ros2Camera::Open(context_, options));
    ASSIGN_OR_RETURN(const Rig rig, camera->AwaitRig(stop));
    return LiveStream::Open(rig, std::move(camera), OptionsOf());
  }
  absl::Status CheckLive() const override {
    ASSIGN_OR_RETURN(const std::optional<Rig> rig, ReadRig());
    return rig.has_value() ? LiveStream::Check(*rig, OptionsOf()) : absl::OkStatus();
  }

 private:
  LiveOptions OptionsOf() const {
    return {.name = absl::StrCat("ros2:", context_->names().full_name()),
            .pair_within_ns = std::llround(1e6 * context_->settings().pair_within_ms),
            .registers = options_.registers};
  }
  absl::StatusOr<std::optional<Rig>> ReadRig() const {
    if (options_.rig.empty()) return std::nullopt;
    ASSIGN_OR_RETURN(Rig rig, ReadLiveRig("ros2", options_));
    return rig;
  }

  std::shared_ptr<Ros2Context> context_;
  LiveSourceOptions options_;
};

}  // namespace

void RegisterRos2Source(std::shared_ptr<Ros2Context> context) {
  RegisterSourceKind(
      {"ros2", "ros2:topics",
       [context =
            std::move(context)](absl::string_view place) -> absl::StatusOr<SharedKindSettings> {
         if (place == "topics") return std::make_shared<Ros2SourceSettings>(context);
         return absl::InvalidArgumentError(absl::StrCat(
             "ros2:", place,
             ": is called ros2:topics: which ones is said by --ros-args -r (docs/ros2.md)"));
       }});
}

}  // namespace corbslam::client_agent
