#include "services/convert/geometry.h"

#include <algorithm>
#include <cmath>

#include "services/convert/errors.h"
#include "services/convert/lens.h"
#include "services/convert/limits.h"
#include "slam/exchange/overlap.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr int kCovarianceEntries = 28;

template <typename Field>
absl::StatusOr<Eigen::Quaterniond> ReadRotation(const Field& wxyz) {
  if (wxyz.size() != 4) return BadLength("rotation_wxyz", wxyz.size(), 4);
  return CheckRotation(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

template <typename Field>
absl::StatusOr<Eigen::Vector3d> ReadTranslation(const Field& xyz) {
  if (xyz.size() != 3) return BadLength("translation", xyz.size(), 3);
  const Eigen::Vector3d translation(xyz[0], xyz[1], xyz[2]);
  RETURN_IF_ERROR(Locate(CheckPosition(translation), "translation"));
  return translation;
}

template <typename Proto>
void WriteMotion(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation,
                 Proto* proto) {
  for (const double value : {rotation.w(), rotation.x(), rotation.y(), rotation.z()}) {
    proto->add_rotation_wxyz(value);
  }
  for (const double value : translation) proto->add_translation(value);
}

}  // namespace

absl::Status CheckPosition(const Eigen::Vector3d& position) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(position[i]) || std::abs(position[i]) > kMaxCoordinate) {
      return OutOfRange(absl::StrCat("coordinate ", i), position[i], -kMaxCoordinate,
                        kMaxCoordinate);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<Eigen::Quaterniond> CheckRotation(double w, double x, double y, double z) {
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  if (!std::isfinite(length) || std::abs(length - 1) > kQuaternionTolerance) {
    return OutOfRange("length of the quaternion", length, 1 - kQuaternionTolerance,
                      1 + kQuaternionTolerance);
  }
  // A quaternion that is of unit length but for rounding is kept to the bit.
  const double scale = std::abs(length - 1) < 1e-12 ? 1 : 1 / length;
  return Eigen::Quaterniond(w * scale, x * scale, y * scale, z * scale);
}

void ToProto(const Rigid3d& rigid, v1::Rigid* proto) {
  WriteMotion(rigid.rotation, rigid.translation, proto);
}

void ToProto(const Similarity3d& similarity, v1::Similarity* proto) {
  WriteMotion(similarity.rotation, similarity.translation, proto);
  if (similarity.scale != 1) proto->set_scale(similarity.scale);
}

void ToProto(const Matrix7d& covariance, google::protobuf::RepeatedField<double>* proto) {
  if (covariance.isZero(0)) return;
  for (int row = 0; row < 7; ++row) {
    for (int column = row; column < 7; ++column) proto->Add(covariance(row, column));
  }
}

void ToProto(const Camera& camera, v1::Camera* proto) {
  proto->set_fx_px(camera.fx_px);
  proto->set_fy_px(camera.fy_px);
  proto->set_cx_px(camera.cx_px);
  proto->set_cy_px(camera.cy_px);
  proto->set_width_px(static_cast<uint32_t>(camera.width_px));
  proto->set_height_px(static_cast<uint32_t>(camera.height_px));
  proto->set_baseline_m(camera.baseline_m);
  proto->set_close_depth_m(camera.close_depth_m);
}

void ToProto(const RecordedCamera& recorded, v1::RecordedCamera* proto) {
  const RawCamera& lens = recorded.lens;
  proto->set_fx_px(lens.fx_px);
  proto->set_fy_px(lens.fy_px);
  proto->set_cx_px(lens.cx_px);
  proto->set_cy_px(lens.cy_px);
  LensToProto(lens.lens, proto);
  ToProto(recorded.camera_from_recorded, proto->mutable_camera_from_recorded());
  if (!recorded.body_from_recorded.has_value()) return;
  ToProto(*recorded.body_from_recorded, proto->mutable_body_from_recorded());
}

v1::PosesOf ToProto(PosesOf poses_of) {
  switch (poses_of) {
    case PosesOf::kRecordedCamera:
      return v1::POSES_OF_CAMERA;
    case PosesOf::kRectifiedCamera:
      return v1::POSES_OF_RECTIFIED_CAMERA;
    case PosesOf::kBody:
      return v1::POSES_OF_BODY;
  }
  return v1::POSES_OF_UNSPECIFIED;
}

absl::StatusOr<Rigid3d> FromProto(const v1::Rigid& proto) {
  Rigid3d rigid;
  ASSIGN_OR_RETURN(rigid.rotation, ReadRotation(proto.rotation_wxyz()));
  ASSIGN_OR_RETURN(rigid.translation, ReadTranslation(proto.translation()));
  return rigid;
}

absl::StatusOr<Similarity3d> FromProto(const v1::Similarity& proto) {
  Similarity3d similarity;
  ASSIGN_OR_RETURN(similarity.rotation, ReadRotation(proto.rotation_wxyz()));
  ASSIGN_OR_RETURN(similarity.translation, ReadTranslation(proto.translation()));
  if (proto.has_scale()) similarity.scale = proto.scale();
  // The condition is written so that NaN fails.
  if (!(similarity.scale >= kMinScale && similarity.scale <= kMaxScale)) {
    return OutOfRange("scale", similarity.scale, kMinScale, kMaxScale);
  }
  return similarity;
}

absl::StatusOr<Matrix7d> FromProto(const google::protobuf::RepeatedField<double>& covariance) {
  Matrix7d matrix = Matrix7d::Zero();
  if (covariance.empty()) return matrix;
  if (covariance.size() != kCovarianceEntries) {
    return BadLength("covariance", covariance.size(), kCovarianceEntries);
  }
  int next = 0;
  for (int row = 0; row < 7; ++row) {
    for (int column = row; column < 7; ++column) {
      matrix(row, column) = matrix(column, row) = covariance[next++];
    }
  }
  if (!IsCovariance(matrix)) {
    return absl::InvalidArgumentError(
        "covariance has an entry that is not finite, or a negative eigenvalue");
  }
  return matrix;
}

absl::StatusOr<Camera> FromProto(const v1::Camera& proto) {
  Camera camera;
  camera.fx_px = proto.fx_px();
  camera.fy_px = proto.fy_px();
  camera.cx_px = proto.cx_px();
  camera.cy_px = proto.cy_px();
  // A size beyond int's range is clamped to one that is beyond Validate's.
  camera.width_px = static_cast<int>(std::min(proto.width_px(), 1u << 30));
  camera.height_px = static_cast<int>(std::min(proto.height_px(), 1u << 30));
  camera.baseline_m = proto.baseline_m();
  camera.close_depth_m = proto.close_depth_m();
  RETURN_IF_ERROR(Validate(camera));
  return camera;
}

absl::StatusOr<RecordedCamera> FromProto(const v1::RecordedCamera& proto) {
  RecordedCamera recorded;
  recorded.lens = {proto.fx_px(), proto.fy_px(), proto.cx_px(), proto.cy_px(), {}};
  ASSIGN_OR_RETURN(recorded.lens.lens, LensFromProto(proto));
  if (proto.has_camera_from_recorded()) {
    ASSIGN_OR_RETURN(recorded.camera_from_recorded, FromProto(proto.camera_from_recorded()));
  }
  if (proto.has_body_from_recorded()) {
    ASSIGN_OR_RETURN(recorded.body_from_recorded, FromProto(proto.body_from_recorded()));
  }
  RETURN_IF_ERROR(Validate(recorded));
  return recorded;
}

absl::StatusOr<PosesOf> FromProto(v1::PosesOf poses_of) {
  if (poses_of == v1::POSES_OF_UNSPECIFIED) return PosesOf::kRecordedCamera;
  for (const PosesOf known :
       {PosesOf::kRecordedCamera, PosesOf::kRectifiedCamera, PosesOf::kBody}) {
    if (poses_of == ToProto(known)) return known;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("poses_of is ", static_cast<int>(poses_of), ", must be 0 to 3"));
}

}  // namespace corbslam::services
