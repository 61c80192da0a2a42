#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/image_file.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

// Depth from this many baselines on is too coarse to make a point from one view.
constexpr double kCloseDepth_baselines = 35;

using ProjectionRows = std::map<std::string, std::vector<double>>;  // "P0" -> 12 numbers.

std::string ImagePath(const std::string& directory, int camera, size_t frame) {
  return absl::StrFormat("%s/image_%d/%06d.png", directory, camera, frame);
}

absl::StatusOr<ProjectionRows> ReadProjections(const std::string& path) {
  ProjectionRows rows;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(text, absl::MaxSplits(':', 1));
    // Tr and the colour cameras are not ours.
    if (parts.first != "P0" && parts.first != "P1") return absl::OkStatus();
    const std::vector<absl::string_view> fields =
        absl::StrSplit(parts.second, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    if (fields.size() != 12) {
      return LineError(path, line,
                       absl::StrCat(parts.first, " has ", fields.size(), " numbers instead of 12"));
    }
    ASSIGN_OR_RETURN(rows[std::string(parts.first)], ParseNumbers(fields, path, line));
    return absl::OkStatus();
  }));
  for (const char* name : {"P0", "P1"}) {
    if (!rows.contains(name)) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": no line ", name));
    }
  }
  return rows;
}

absl::StatusOr<Camera> ReadCamera(const std::string& directory) {
  const std::string path = directory + "/calib.txt";
  ASSIGN_OR_RETURN(const ProjectionRows rows, ReadProjections(path));
  ASSIGN_OR_RETURN(const cv::Mat first, ReadGreyImage(ImagePath(directory, 0, 0)));
  const std::vector<double>& left = rows.at("P0");
  const std::vector<double>& right = rows.at("P1");
  Camera camera;
  camera.fx_px = left[0];
  camera.fy_px = left[5];
  camera.cx_px = left[2];
  camera.cy_px = left[6];
  camera.width_px = first.cols;
  camera.height_px = first.rows;
  camera.baseline_m = (left[3] - right[3]) / right[0];
  camera.close_depth_m = kCloseDepth_baselines * camera.baseline_m;
  if (const absl::Status status = Validate(camera); !status.ok() || !camera.IsMetric()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ",
                     status.ok() ? absl::StrCat("baseline ", camera.baseline_m, " m")
                                 : std::string(status.message())));
  }
  return camera;
}

absl::StatusOr<std::vector<int64_t>> ReadTimes(const std::string& path) {
  std::vector<int64_t> times_ns;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const absl::StatusOr<int64_t> time_ns = ParseSeconds(text);
    if (!time_ns.ok()) return LineError(path, line, time_ns.status().message());
    times_ns.push_back(*time_ns);
    return absl::OkStatus();
  }));
  if (times_ns.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": no times"));
  return times_ns;
}

class KittiReader : public FrameReader {
 public:
  KittiReader(std::string directory, const Camera& camera, std::vector<int64_t> times_ns)
      : directory_(std::move(directory)),
        calibration_(StereoCalibration{camera, std::nullopt}),
        times_ns_(std::move(times_ns)) {}

  const SensorCalibration& calibration() const override { return calibration_; }
  size_t frame_count() const override { return times_ns_.size(); }
  int64_t timestamp_ns(size_t frame) const override { return times_ns_[frame]; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    SensorImages images;
    images.timestamp_ns = times_ns_[frame];
    ASSIGN_OR_RETURN(images.grey, ReadGreyImage(ImagePath(directory_, 0, frame)));
    ASSIGN_OR_RETURN(images.right, ReadGreyImage(ImagePath(directory_, 1, frame)));
    return images;
  }

 private:
  const std::string directory_;
  const SensorCalibration calibration_;
  const std::vector<int64_t> times_ns_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenKitti(const std::string& directory) {
  ASSIGN_OR_RETURN(const Camera camera, ReadCamera(directory));
  ASSIGN_OR_RETURN(std::vector<int64_t> times_ns, ReadTimes(directory + "/times.txt"));
  return std::make_unique<KittiReader>(directory, camera, std::move(times_ns));
}

}  // namespace corbslam
