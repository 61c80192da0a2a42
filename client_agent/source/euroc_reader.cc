#include <map>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client_agent/source/euroc_calibration.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/image_file.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

constexpr double kCloseDepth_baselines = 50;

struct StereoFiles {
  int64_t timestamp_ns = 0;
  std::string left;
  std::string right;
};

absl::StatusOr<std::map<int64_t, std::string>> ReadList(const std::string& camera_directory) {
  const std::string path = camera_directory + "/data.csv";
  std::map<int64_t, std::string> files;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const std::pair<absl::string_view, absl::string_view> fields =
        absl::StrSplit(text, absl::MaxSplits(',', 1));
    int64_t timestamp_ns = 0;
    if (!absl::SimpleAtoi(fields.first, &timestamp_ns)) {
      return LineError(path, line, absl::StrCat("field 1 is no time: ", fields.first));
    }
    const absl::string_view name = absl::StripAsciiWhitespace(fields.second);
    if (name.empty()) return LineError(path, line, "field 2 names no file");
    files[timestamp_ns] = absl::StrCat(camera_directory, "/data/", name);
    return absl::OkStatus();
  }));
  return files;
}

absl::StatusOr<std::vector<StereoFiles>> PairUp(const std::string& root) {
  ASSIGN_OR_RETURN(const auto left, ReadList(root + "/cam0"));
  ASSIGN_OR_RETURN(const auto right, ReadList(root + "/cam1"));
  std::vector<StereoFiles> pairs;
  for (const auto& [timestamp_ns, path] : left) {
    const auto other = right.find(timestamp_ns);
    if (other != right.end()) pairs.push_back({timestamp_ns, path, other->second});
  }
  if (pairs.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(root, ": cam0 and cam1 have no common times"));
  }
  return pairs;
}

absl::StatusOr<StereoCalibration> ReadCalibration(const std::string& root) {
  ASSIGN_OR_RETURN(const EurocCamera left, ReadEurocCamera(root + "/cam0/sensor.yaml"));
  ASSIGN_OR_RETURN(const EurocCamera right, ReadEurocCamera(root + "/cam1/sensor.yaml"));
  if (left.width_px != right.width_px || left.height_px != right.height_px) {
    return absl::InvalidArgumentError(absl::StrCat(root, ": cam0 and cam1 differ in resolution"));
  }
  RawStereo raw;
  raw.left = left.intrinsics;
  raw.right = right.intrinsics;
  raw.right_from_left = right.body_from_camera.Inverse() * left.body_from_camera;
  raw.width_px = left.width_px;
  raw.height_px = left.height_px;
  if (const absl::Status status = Validate(raw); !status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(root, ": ", status.message()));
  }
  StereoCalibration calibration;
  calibration.camera.close_depth_m = kCloseDepth_baselines * raw.right_from_left.translation.norm();
  calibration.raw = raw;
  calibration.body_from_raw_left = left.body_from_camera;
  return calibration;
}

class EurocReader : public FrameReader {
 public:
  EurocReader(StereoCalibration calibration, std::vector<StereoFiles> frames)
      : calibration_(std::move(calibration)), frames_(std::move(frames)) {}

  const SensorCalibration& calibration() const override { return calibration_; }
  size_t frame_count() const override { return frames_.size(); }
  int64_t timestamp_ns(size_t frame) const override { return frames_[frame].timestamp_ns; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    SensorImages images;
    images.timestamp_ns = frames_[frame].timestamp_ns;
    ASSIGN_OR_RETURN(images.grey, ReadGreyImage(frames_[frame].left));
    ASSIGN_OR_RETURN(images.right, ReadGreyImage(frames_[frame].right));
    return images;
  }

 private:
  const SensorCalibration calibration_;
  const std::vector<StereoFiles> frames_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenEuroc(const std::string& directory) {
  const std::string root = EurocRoot(directory);
  ASSIGN_OR_RETURN(StereoCalibration calibration, ReadCalibration(root));
  ASSIGN_OR_RETURN(std::vector<StereoFiles> frames, PairUp(root));
  return std::make_unique<EurocReader>(std::move(calibration), std::move(frames));
}

}  // namespace corbslam
