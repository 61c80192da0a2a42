#include "client_agent/source/bag/camera_info_rig.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/topic_names.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/rig/rectified_motion.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// As of kitti:'s rectified pairs.
constexpr double kRectifiedClose_baselines = 35;
constexpr double kSame_px = 0.01;
constexpr double kSameRotation_rad = 1e-4;
// Of the baseline, how far off x a camera of a rectified pair may sit by /tf_static.
constexpr double kOffAxisShare = 0.01;

struct InfoCamera {
  RigCamera camera;
  bool is_pinhole = false;  // Nothing bends or turns its pictures: P holds.
  Eigen::Matrix3d rectified_from_camera = Eigen::Matrix3d::Identity();
};

absl::Status BadInfo(const std::string& bag, const PictureTopic& picture, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(bag, ": ", picture.info_topic, ": ", what, ", or give ?rig=FILE"));
}

absl::Status NoInfo(const std::string& bag, const PictureTopic& picture, absl::string_view option) {
  return absl::NotFoundError(absl::StrCat(
      bag, ": ", picture.name(), " has no CameraInfo: name its topic by ?", option,
      "_info=TOPIC, or give the cameras by ?rig=FILE ('corbslam rig convert' makes it of what "
      "Kalibr, ROS or OpenCV wrote)"));
}

// A driver that bins pixels, or cuts out a part, sends pictures of another size than K and P are
// of. `first` and `shift_px` become what was cut off and by how much pictures are smaller.
absl::Status FitToPicture(const std::string& bag, const PictureTopic& picture, double& shrink_x,
                          double& shrink_y, bool& is_cut) {
  const RosCameraInfo& info = *picture.info;
  const cv::Size size = picture.form.size;
  shrink_x = shrink_y = 1;
  is_cut = false;
  const auto is_size = [&](uint32_t width_px, uint32_t height_px) {
    return static_cast<int64_t>(width_px) == size.width &&
           static_cast<int64_t>(height_px) == size.height;
  };
  if (is_size(info.width_px, info.height_px) || size.area() == 0) return absl::OkStatus();
  const uint32_t binning_x = std::max(info.binning_x, 1u);
  const uint32_t binning_y = std::max(info.binning_y, 1u);
  is_cut = info.roi_width_px > 0 && info.roi_height_px > 0;
  const uint32_t width_px = is_cut ? info.roi_width_px : info.width_px;
  const uint32_t height_px = is_cut ? info.roi_height_px : info.height_px;
  shrink_x = binning_x;
  shrink_y = binning_y;
  if (is_size(width_px / binning_x, height_px / binning_y)) return absl::OkStatus();
  return BadInfo(bag, picture,
                 absl::StrCat("width, height are ", info.width_px, ", ", info.height_px,
                              ", its pictures have ", size.width, "x", size.height,
                              " pixels, which neither its binning nor its roi explains: have the "
                              "driver say the size that it sends"));
}

template <typename Matrix>
absl::Status CheckMatrix(const std::string& bag, const PictureTopic& picture,
                         absl::string_view name, const Matrix& matrix, size_t row) {
  const bool is_finite =
      std::all_of(matrix.begin(), matrix.end(), [](double x) { return std::isfinite(x); });
  if (is_finite && matrix[0] > 0 && matrix[row + 1] > 0) return absl::OkStatus();
  return BadInfo(bag, picture,
                 absl::StrCat(name, " has the focal lengths ", matrix[0], ", ", matrix[row + 1],
                              ", must be above 0: was this camera calibrated? Calibrate it"));
}

absl::StatusOr<LensModel> LensOf(const std::string& bag, const PictureTopic& picture) {
  const RosCameraInfo& info = *picture.info;
  const bool bends = std::any_of(info.d.begin(), info.d.end(), [](double k) { return k != 0; });
  // Drivers of rectified pictures leave the name empty.
  if (!bends && info.distortion_model != "equidistant") return LensModel(RadialTangential());
  absl::StatusOr<LensModel> lens =
      LensOfName(info.distortion_model.empty() ? "plumb_bob" : info.distortion_model, info.d);
  if (lens.ok()) return lens;
  return BadInfo(bag, picture,
                 absl::StrCat("distortion_model, D: ", lens.status().message(),
                              ": record rectified pictures (image_rect)"));
}

absl::StatusOr<InfoCamera> CameraOfP(const std::string& bag, const PictureTopic& picture) {
  const std::array<double, 12>& p = picture.info->p;
  RETURN_IF_ERROR(CheckMatrix(bag, picture, "P", p, 4));
  InfoCamera made;
  made.camera.raw = {p[0], p[5], p[2], p[6], RadialTangential()};
  made.is_pinhole = true;
  return made;
}

absl::StatusOr<InfoCamera> CameraOfK(const std::string& bag, const PictureTopic& picture) {
  const RosCameraInfo& info = *picture.info;
  const std::array<double, 9>& k = info.k;
  RETURN_IF_ERROR(CheckMatrix(bag, picture, "K", k, 3));
  InfoCamera made;
  ASSIGN_OR_RETURN(made.camera.raw.lens, LensOf(bag, picture));
  made.camera.raw.fx_px = k[0];
  made.camera.raw.fy_px = k[4];
  made.camera.raw.cx_px = k[2];
  made.camera.raw.cy_px = k[5];
  const bool has_r = std::any_of(info.r.begin(), info.r.end(), [](double x) { return x != 0; });
  if (has_r)
    made.rectified_from_camera =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.r.data());
  const Eigen::Matrix3d error =
      made.rectified_from_camera * made.rectified_from_camera.transpose() -
      Eigen::Matrix3d::Identity();
  if (!(error.norm() < 0.01) || made.rectified_from_camera.determinant() < 0) {
    return BadInfo(bag, picture, "R holds no rotation");
  }
  const auto* const bent = std::get_if<RadialTangential>(&made.camera.raw.lens);
  const std::array<double, 12>& p = info.p;
  made.is_pinhole =
      bent != nullptr && bent->IsZero() &&
      (made.rectified_from_camera - Eigen::Matrix3d::Identity()).norm() < kSameRotation_rad &&
      std::abs(p[0] - k[0]) < kSame_px && std::abs(p[5] - k[4]) < kSame_px &&
      std::abs(p[2] - k[2]) < kSame_px && std::abs(p[6] - k[5]) < kSame_px;
  return made;
}

absl::StatusOr<InfoCamera> CameraOf(const std::string& bag, const PictureTopic& picture,
                                    absl::string_view option, SourceFindings& findings) {
  if (!picture.info.has_value()) return NoInfo(bag, picture, option);
  ASSIGN_OR_RETURN(InfoCamera made,
                   SaysRectified(picture.base) ? CameraOfP(bag, picture) : CameraOfK(bag, picture));
  double shrink_x = 1;
  double shrink_y = 1;
  bool is_cut = false;
  const bool has_size = picture.info->width_px > 0 && picture.info->height_px > 0;
  if (has_size) RETURN_IF_ERROR(FitToPicture(bag, picture, shrink_x, shrink_y, is_cut));
  RawCamera& raw = made.camera.raw;
  if (is_cut) {
    raw.cx_px -= picture.info->roi_x_px;
    raw.cy_px -= picture.info->roi_y_px;
  }
  raw.fx_px /= shrink_x;
  raw.cx_px /= shrink_x;
  raw.fy_px /= shrink_y;
  raw.cy_px /= shrink_y;
  made.camera.width_px = picture.form.size.width;
  made.camera.height_px = picture.form.size.height;
  if (picture.info_changes) {
    findings.push_back(
        {FindingLevel::kWarning, "bag-calibration-changes",
         absl::StrCat(bag, ": ", picture.info_topic,
                      ": the calibration changes within the bag; its first one is taken")});
  }
  return made;
}

absl::StatusOr<Rigid3d> MotionOfFrames(const std::string& bag, const TransformTree& tree,
                                       const PictureTopic& target, const PictureTopic& source,
                                       absl::string_view instead) {
  const auto motion = tree.TargetFromSource(target.frame_id, source.frame_id);
  if (motion.has_value() && target.frame_id != source.frame_id) return *motion;
  const std::string why =
      target.frame_id == source.frame_id
          ? absl::StrCat("both pictures have the frame '", target.frame_id, "'")
          : absl::StrCat(tree.empty() ? "there is no /tf_static" : "/tf_static has no way",
                         " from frame '", source.frame_id, "' to '", target.frame_id, "'");
  return absl::InvalidArgumentError(
      absl::StrCat(bag, ": ", instead, ", and ", why, ": give the cameras by ?rig=FILE"));
}

bool IsAlongX(const Rigid3d& right_from_left) {
  const Eigen::Vector3d& t = right_from_left.translation;
  return RotationAngle(right_from_left.rotation) < kSameRotation_rad && t.x() < 0 &&
         std::hypot(t.y(), t.z()) < kOffAxisShare * -t.x();
}

absl::Status PlaceRight(const std::string& bag, const RigChoice& choice, const TransformTree& tree,
                        const InfoCamera& left, const InfoCamera& right, Rig& rig) {
  const std::optional<double> baseline_m = BaselineOfP(choice.first, choice.second);
  rig.rectified = left.is_pinhole && right.is_pinhole;
  if (baseline_m.has_value() && *baseline_m < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        bag, ": by P's fourth column ", choice.second.info_topic, " is ", -*baseline_m,
        " m to the left of ", choice.first.info_topic,
        ": exchange them (?left=", choice.second.name(), "&right=", choice.first.name(), ")"));
  }
  if (baseline_m.has_value()) {
    rig.baseline_m = *baseline_m;
    rig.right_from_left =
        MotionOfRectified(left.rectified_from_camera, right.rectified_from_camera, *baseline_m);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(rig.right_from_left,
                   MotionOfFrames(bag, tree, choice.second, choice.first,
                                  absl::StrCat("P of ", choice.first.info_topic, " and ",
                                               choice.second.info_topic, " has no baseline")));
  rig.rectified = rig.rectified && IsAlongX(rig.right_from_left);
  rig.baseline_m = -rig.right_from_left.translation.x();
  return absl::OkStatus();
}

absl::StatusOr<CameraInfoRig> MakeStereo(const std::string& bag, const RigChoice& choice,
                                         const TransformTree& tree) {
  CameraInfoRig made;
  ASSIGN_OR_RETURN(const InfoCamera left, CameraOf(bag, choice.first, "left", made.findings));
  ASSIGN_OR_RETURN(const InfoCamera right, CameraOf(bag, choice.second, "right", made.findings));
  Rig& rig = made.rig;
  rig.kind = RigKind::kStereo;
  rig.cameras = {left.camera, right.camera};
  RETURN_IF_ERROR(PlaceRight(bag, choice, tree, left, right, rig));
  if (rig.rectified) rig.close_depth_m = kRectifiedClose_baselines * rig.baseline_m;
  made.from =
      absl::StrCat(choice.first.info_topic, ", ", choice.second.info_topic,
                   BaselineOfP(choice.first, choice.second).has_value() ? "" : ", /tf_static");
  return made;
}

// Depth of a camera of its own, whose pictures are to be registered.
absl::Status PlaceDepth(const std::string& bag, const RigChoice& choice, const TransformTree& tree,
                        const BagOptions& options, CameraInfoRig& made) {
  const PictureTopic& picture = choice.first;
  const PictureTopic& depth = choice.second;
  const bool same_size = picture.form.size == depth.form.size;
  const bool is_told = options.registers.has_value();
  if (!is_told && same_size && !depth.info.has_value()) {
    made.findings.push_back(
        {FindingLevel::kWarning, "bag-depth-assumed-registered",
         absl::StrCat(bag, ": ", depth.name(), " has no CameraInfo and the size of ",
                      picture.name(), ": taken as registered to it; say ?register=0 if it is")});
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const InfoCamera camera, CameraOf(bag, depth, "depth", made.findings));
  ASSIGN_OR_RETURN(made.rig.depth.colour_from_depth,
                   MotionOfFrames(bag, tree, picture, depth,
                                  absl::StrCat(depth.name(), " is not registered to ",
                                               picture.name(), " (?register=0 if it is)")));
  made.rig.depth.camera = camera.camera;
  absl::StrAppend(&made.from, ", ", depth.info_topic, ", /tf_static");
  return absl::OkStatus();
}

absl::StatusOr<CameraInfoRig> MakeRgbd(const std::string& bag, const RigChoice& choice,
                                       const TransformTree& tree, const BagOptions& options) {
  CameraInfoRig made;
  ASSIGN_OR_RETURN(const InfoCamera camera, CameraOf(bag, choice.first, "left", made.findings));
  made.rig.kind = RigKind::kRgbd;
  made.rig.cameras = {camera.camera};
  made.from = choice.first.info_topic;
  made.rig.depth.units_per_m = options.depth_units_per_m.value_or(made.rig.depth.units_per_m);
  made.depth_units_from = options.depth_units_per_m.has_value()
                              ? "?depth-units"
                              : "ROS (REP 118): millimetres in 16 bits, metres in floats";
  if (!choice.is_registered) RETURN_IF_ERROR(PlaceDepth(bag, choice, tree, options, made));
  return made;
}

}  // namespace

absl::StatusOr<CameraInfoRig> MakeCameraInfoRig(const std::string& bag, const RigChoice& choice,
                                                const TransformTree& tree,
                                                const BagOptions& options) {
  absl::StatusOr<CameraInfoRig> made = choice.kind == RigKind::kStereo
                                           ? MakeStereo(bag, choice, tree)
                                           : MakeRgbd(bag, choice, tree, options);
  RETURN_IF_ERROR(made.status());
  made->from = absl::StrCat(bag, ": ", made->from);
  if (const absl::Status valid = Validate(made->rig); !valid.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(made->from, ": ", valid.message()));
  }
  return made;
}

}  // namespace corbslam::client_agent
