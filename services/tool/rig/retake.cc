#include "services/tool/rig/retake.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/rig/rig_file.h"
#include "slam/camera/pair_geometry.h"
#include "slam/rendering/map_picture.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using client_agent::FrameReader;
using client_agent::FramesOf;
using client_agent::Rig;
using client_agent::RigCamera;
using client_agent::RigKind;
using client_agent::SourceSpec;

namespace {

constexpr double kSameBaseline = 0.01;

// Returns for each pixel of a camera (CV_32FC2) where the recording's rectified picture has it.
cv::Mat PixelsOf(const RigCamera& camera, const Eigen::Quaterniond& rectified_from_raw,
                 const Camera& recorded) {
  cv::Mat pixels(camera.height_px, camera.width_px, CV_32FC2, cv::Scalar(-10, -10));
  for (int y = 0; y < pixels.rows; ++y) {
    for (int x = 0; x < pixels.cols; ++x) {
      const std::optional<Eigen::Vector3d> raw = UnprojectRaw(camera.raw, Eigen::Vector2d(x, y));
      if (!raw.has_value()) continue;
      const Eigen::Vector3d ray = rectified_from_raw * *raw;
      if (ray.z() <= 0.05) continue;
      const Eigen::Vector2d pixel = Project(recorded, ray);
      if (!(pixel.cwiseAbs().maxCoeff() < 1e5)) continue;
      pixels.at<cv::Vec2f>(y, x) = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
    }
  }
  return pixels;
}

absl::Status WriteRetaken(const cv::Mat& picture, const cv::Mat& pixels, const std::string& path) {
  cv::Mat retaken;
  cv::remap(picture, retaken, pixels, cv::noArray(), cv::INTER_CUBIC);
  return WriteImage(retaken, path);
}

absl::StatusOr<StereoCalibration> RectifiedOf(const FrameReader& reader) {
  const auto* const stereo = std::get_if<StereoCalibration>(&reader.calibration());
  if (stereo == nullptr || stereo->raw.has_value()) {
    return absl::InvalidArgumentError("only recordings of rectified stereo pairs are taken again");
  }
  return *stereo;
}

absl::Status CheckRig(const Rig& rig, const StereoCalibration& recorded) {
  if (rig.kind != RigKind::kStereo || rig.rectified) {
    return absl::InvalidArgumentError("the rig must be of a stereo pair that is not rectified");
  }
  const double baseline_m = rig.right_from_left.translation.norm();
  const double recorded_m = recorded.camera.baseline_m;
  if (std::abs(baseline_m / recorded_m - 1) <= kSameBaseline) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("the rig's cameras are ", baseline_m,
                                                 " m apart, those of the recording ", recorded_m));
}

}  // namespace

absl::StatusOr<size_t> Retake(const FrameReader& reader, const SourceSpec& spec, const Rig& rig,
                              const std::string& folder) {
  ASSIGN_OR_RETURN(const StereoCalibration recorded, RectifiedOf(reader));
  RETURN_IF_ERROR(CheckRig(rig, recorded));
  for (const char* side : {"/image_0", "/image_1"}) RETURN_IF_ERROR(MakeFolder(folder + side));
  const PairRotations rotations = RotationsOf(rig.right_from_left);
  Camera right = recorded.camera;
  right.cx_px += recorded.right_cx_offset_px;
  const cv::Mat left_pixels =
      PixelsOf(rig.cameras[0], rotations.rectified_from_left, recorded.camera);
  const cv::Mat right_pixels = PixelsOf(rig.cameras[1], rotations.rectified_from_right, right);
  std::vector<std::string> times;
  for (const size_t frame : FramesOf(spec, reader.frame_count())) {
    ASSIGN_OR_RETURN(const SensorImages images, reader.Read(frame));
    const std::string name = absl::StrFormat("%06d.png", times.size());
    RETURN_IF_ERROR(WriteRetaken(images.grey, left_pixels, folder + "/image_0/" + name));
    RETURN_IF_ERROR(WriteRetaken(images.right, right_pixels, folder + "/image_1/" + name));
    times.push_back(FormatSeconds(reader.timestamp_ns(frame)));
  }
  RETURN_IF_ERROR(WriteLines(times, folder + "/times.txt"));
  const std::vector<std::string> lines =
      absl::StrSplit(FormatRig(rig, "a recording that was taken again"), '\n');
  RETURN_IF_ERROR(WriteLines(lines, folder + "/rig.yaml"));
  return times.size();
}

}  // namespace corbslam::services
