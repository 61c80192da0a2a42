#include "client_agent/live/gstreamer/gst_source.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client_agent/live/gstreamer/device_pipelines.h"
#include "client_agent/live/gstreamer/gst_camera.h"
#include "client_agent/live/live_options.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_kinds.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// What the kinds leave to options, beside those of every camera.
struct GstOptions {
  LiveSourceOptions live;
  std::string layout;
  DeviceMode mode;  // Of kinds that name devices.
};

// Options end at '&', and begin behind '?': pipelines that hold these write them as URLs do.
std::string Decode(absl::string_view text) {
  return absl::StrReplaceAll(text, {{"%3F", "?"}, {"%26", "&"}, {"%25", "%"}});
}

class GstSettings : public KindSettings {
 public:
  GstSettings(std::string kind, std::string place)
      : kind_(std::move(kind)), place_(std::move(place)) {}

  absl::string_view kind() const override { return kind_; }
  std::vector<absl::string_view> OptionNames() const override {
    std::vector<absl::string_view> names = LiveOptionNames();
    names.emplace_back("layout");
    if (NamesDevices()) names.insert(names.end(), {"format", "size", "rate"});
    return names;
  }
  absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                          absl::string_view value) const override {
    auto changed = std::make_shared<GstSettings>(*this);
    RETURN_IF_ERROR(changed->Set(key, value));
    return changed;
  }
  absl::Status Validate() const override {
    RETURN_IF_ERROR(CheckNamed());
    const bool one_picture = !options_.layout.empty();
    const size_t cameras = Cameras().size();
    if (cameras > 2) {
      return absl::InvalidArgumentError(
          absl::StrCat(kind_, ":", place_, ": names ", cameras, " cameras, a frame has two"));
    }
    const bool has_second = cameras == 2;
    if (has_second && NamesDevices() && DeviceOf(Cameras()[0]) == DeviceOf(Cameras()[1])) {
      return absl::InvalidArgumentError(
          absl::StrCat(kind_, ":", place_,
                       ": names the same camera twice: a pair is of two cameras, or of one "
                       "whose picture holds both halves (?layout=side-by-side)"));
    }
    if (!one_picture || !has_second) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        kind_, ":", place_, ": one picture with both halves (?layout=) and a second camera"));
  }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override {
    auto formatted = FormatLiveOptions(options_.live);
    for (const auto& [key, value] : {std::pair("layout", options_.layout),
                                     {"format", options_.mode.format},
                                     {"size", options_.mode.size},
                                     {"rate", options_.mode.rate}}) {
      if (!value.empty()) formatted.emplace_back(key, value);
    }
    return formatted;
  }
  uint64_t noise_seed() const override { return 1; }
  bool turned() const override { return false; }
  bool is_live() const override { return true; }
  bool trusts_calibration() const override { return options_.live.trust_calibration; }

  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return absl::InvalidArgumentError(absl::StrCat(
        kind_, ": is a live camera, whose frames nobody can list: client_agent plays it"));
  }
  absl::Status CheckLive() const override {
    RETURN_IF_ERROR(Validate());
    ASSIGN_OR_RETURN(const Rig rig, ReadLiveRig(kind_, options_.live));
    RETURN_IF_ERROR(CheckPictures(rig));
    // Reads the mask.
    RETURN_IF_ERROR(LiveStream::Check(rig, StreamOptionsOf()));
    return CheckGstCamera(CameraOf(rig));
  }
  absl::StatusOr<std::unique_ptr<FrameStream>> OpenLive(
      const absl::Notification& /*stop*/) const override {
    ASSIGN_OR_RETURN(const Rig rig, ReadLiveRig(kind_, options_.live));
    RETURN_IF_ERROR(CheckPictures(rig));
    ASSIGN_OR_RETURN(std::unique_ptr<LiveCamera> opened, MakeGstCamera(CameraOf(rig)));
    return LiveStream::Open(rig, std::move(opened), StreamOptionsOf());
  }

 private:
  // Returns an error where a frame has other pictures than the rig cameras.
  absl::Status CheckPictures(const Rig& rig) const {
    const bool has_one = LayoutOf() == GstLayout::kOneCamera;
    if (has_one == (rig.kind == RigKind::kMonocular)) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        kind_, ":", place_, ": ",
        has_one ? "a frame has two pictures: name a second camera (gst:LEFT || RIGHT, v4l2:"
                  "/dev/video0,/dev/video1, aravis:LEFT,RIGHT), or say how one picture holds both "
                  "(?layout=side-by-side, ?layout=one-above), or give the rig of one camera alone "
                  "(kind: monocular)"
                : absl::StrCat("a frame has two pictures, and ", options_.live.rig,
                               " is of one camera alone: name one camera, without ?layout=")));
  }
  GstCameraOptions CameraOf(const Rig& rig) const {
    GstCameraOptions camera;
    camera.first = PipelineOf(0);
    camera.second = PipelineOf(1);
    camera.layout = LayoutOf();
    camera.second_is_depth = rig.kind == RigKind::kRgbd;
    camera.restarts = options_.live.restarts;
    return camera;
  }
  LiveOptions StreamOptionsOf() const {
    LiveOptions options = StreamOptions(absl::StrCat(kind_, ":", place_), options_.live);
    options.one_stamp = LayoutOf() == GstLayout::kSideBySide || LayoutOf() == GstLayout::kOneAbove;
    return options;
  }
  bool NamesDevices() const { return kind_ != "gst"; }
  // Returns an error where a camera or pipeline has no name.
  absl::Status CheckNamed() const {
    const std::vector<std::string> cameras = Cameras();
    const auto is_blank = [](const std::string& text) {
      return absl::StripAsciiWhitespace(text).empty();
    };
    if (std::none_of(cameras.begin(), cameras.end(), is_blank)) return absl::OkStatus();
    const absl::string_view wanted =
        kind_ == "gst"
            ? "a pipeline as gst-launch-1.0 takes it, without its sink, or two with || between them"
        : kind_ == "v4l2"
            ? "devices, as v4l2:/dev/video0,/dev/video1 (v4l2-ctl --list-devices)"
            : "cameras, as aravis:LEFT,RIGHT, or aravis:any (arv-tool-0.8 lists them)";
    return absl::InvalidArgumentError(
        absl::StrCat(kind_, ":", place_, ": names no ",
                     is_blank(cameras[0]) ? (cameras.size() > 1 ? "first " : "") : "second ",
                     "camera: give ", wanted));
  }
  // Returns the device behind a name: links of /dev/v4l lead to one.
  std::string DeviceOf(const std::string& name) const {
    std::error_code error;
    const std::filesystem::path path = std::filesystem::weakly_canonical(name, error);
    return kind_ == "v4l2" && !error ? path.string() : name;
  }
  // The devices, or the pipelines.
  std::vector<std::string> Cameras() const {
    if (NamesDevices()) return absl::StrSplit(place_, ',');
    return absl::StrSplit(place_, "||");
  }

  GstLayout LayoutOf() const {
    if (options_.layout == "side-by-side") return GstLayout::kSideBySide;
    if (options_.layout == "one-above") return GstLayout::kOneAbove;
    return Cameras().size() == 1 ? GstLayout::kOneCamera : GstLayout::kTwoPipelines;
  }
  std::string PipelineOf(size_t which) const {
    const std::vector<std::string> cameras = Cameras();
    if (which >= cameras.size()) return "";
    if (kind_ == "v4l2") return V4l2Pipeline(cameras[which], options_.mode);
    // Devices' own clocks have nothing in common.
    const bool is_pair = cameras.size() == 2;
    if (kind_ == "aravis") {
      return AravisPipeline(Decode(cameras[which]), options_.mode, /*on_arrival=*/is_pair);
    }
    return Decode(cameras[which]);
  }

  absl::Status Set(absl::string_view key, absl::string_view value) {
    if (key == "layout") {
      if (value != "side-by-side" && value != "one-above") {
        return BadLiveOption(key, value, "side-by-side or one-above");
      }
      options_.layout = std::string(value);
    } else if (key == "format") {
      if (kind_ == "aravis") RETURN_IF_ERROR(ValidateAravisFormat(value));
      options_.mode.format = std::string(value);
    } else if (key == "size") {
      RETURN_IF_ERROR(ValidateSize(value));
      options_.mode.size = std::string(value);
    } else if (key == "rate") {
      RETURN_IF_ERROR(ValidateRate(value));
      options_.mode.rate = std::string(value);
    } else {
      return SetLiveOption(key, value, options_.live);
    }
    return absl::OkStatus();
  }

  std::string kind_;
  std::string place_;
  GstOptions options_;
};

SourceKind KindOf(const std::string& name, const std::string& usage) {
  return {name, usage, [name](absl::string_view place) -> absl::StatusOr<SharedKindSettings> {
            return std::make_shared<GstSettings>(name, std::string(place));
          }};
}

}  // namespace

void RegisterGstSources() {
  RegisterSourceKind(KindOf("gst", "gst:LEFT || RIGHT"));
  RegisterSourceKind(KindOf("v4l2", "v4l2:DEVICES"));
  RegisterSourceKind(KindOf("aravis", "aravis:CAMERAS"));
}

bool IsGstSourceHere(absl::string_view kind) {
  if (kind == "v4l2") return GstHasElement("v4l2src");
  if (kind == "aravis") return GstHasElement("aravissrc");
  return true;
}

}  // namespace corbslam::client_agent
