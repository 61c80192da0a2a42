#include "client_agent/live/push/push_source.h"

#include <glog/logging.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/live/push/push_camera.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/rig/rig_file.h"
#include "client_agent/source/source_kinds.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

class PushSettings : public KindSettings {
 public:
  explicit PushSettings(absl::string_view path) : path_(path) {}

  absl::string_view kind() const override { return "push"; }
  std::vector<absl::string_view> OptionNames() const override {
    return {"rig", "trust_calibration"};
  }
  absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                          absl::string_view value) const override {
    auto changed = std::make_shared<PushSettings>(*this);
    if (key == "rig") {
      if (value.empty()) return BadOption(key, value, "a file");
      changed->rig_ = std::string(value);
    } else {
      if (value != "" && value != "0" && value != "1") return BadOption(key, value, "0 or 1");
      changed->trust_calibration_ = value != "0";
    }
    return changed;
  }
  absl::Status Validate() const override {
    if (!path_.empty()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        "push: names no socket: push:/run/corbslam/camera.sock, where the robot listens for a "
        "driver");
  }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override {
    std::vector<std::pair<std::string, std::string>> formatted;
    if (!rig_.empty()) formatted.emplace_back("rig", rig_);
    if (trust_calibration_) formatted.emplace_back("trust_calibration", "1");
    return formatted;
  }
  uint64_t noise_seed() const override { return 1; }
  bool turned() const override { return false; }
  bool is_live() const override { return true; }
  bool trusts_calibration() const override { return trust_calibration_; }

  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return absl::InvalidArgumentError(
        "push: is a live camera, whose frames nobody can list: client_agent plays it");
  }
  absl::StatusOr<std::unique_ptr<FrameStream>> OpenLive(
      const absl::Notification& stop) const override {
    PushCameraOptions options{path_, std::nullopt, trust_calibration_};
    ASSIGN_OR_RETURN(options.rig, ReadRig());
    ASSIGN_OR_RETURN(std::unique_ptr<PushCamera> camera, PushCamera::Open(options));
    ASSIGN_OR_RETURN(const Rig rig, camera->AwaitRig(stop));
    return LiveStream::Open(rig, std::move(camera), OptionsOf());
  }
  absl::Status CheckLive() const override {
    ASSIGN_OR_RETURN(const std::optional<Rig> rig, ReadRig());
    if (rig.has_value()) RETURN_IF_ERROR(LiveStream::Check(*rig, OptionsOf()));
    return UnixListener::Check(path_);
  }

 private:
  // Both pictures of a frame have one time.
  LiveOptions OptionsOf() const {
    return {.name = absl::StrCat("push:", path_), .pair_within_ns = 0, .one_stamp = true};
  }
  static absl::Status BadOption(absl::string_view key, absl::string_view value,
                                absl::string_view wanted) {
    return absl::InvalidArgumentError(
        absl::StrCat("source option ", key, "=", value, ": wants ", wanted));
  }

  // Returns nullopt where the driver is to say it.
  absl::StatusOr<std::optional<Rig>> ReadRig() const {
    if (rig_.empty()) return std::nullopt;
    ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(rig_));
    ASSIGN_OR_RETURN(const SourceFindings findings, JudgeRig(rig, rig_, trust_calibration_));
    for (const SourceFinding& finding : findings) LOG(WARNING) << finding.text;
    return rig;
  }

  std::string path_;
  std::string rig_;
  bool trust_calibration_ = false;
};

}  // namespace

void RegisterPushSource() {
  RegisterSourceKind(
      {"push", "push:SOCKET", [](absl::string_view path) -> absl::StatusOr<SharedKindSettings> {
         return std::make_shared<PushSettings>(path);
       }});
}

}  // namespace corbslam::client_agent
