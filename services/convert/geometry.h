// Converts motions and cameras to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_GEOMETRY_H_
#define CORBSLAM_SERVICES_CONVERT_GEOMETRY_H_

#include "absl/status/statusor.h"
#include "corbslam/v1/geometry.pb.h"
#include "slam/camera/camera.h"
#include "slam/camera/recorded_camera.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::services {

void ToProto(const Rigid3d& rigid, v1::Rigid* proto);
void ToProto(const Similarity3d& similarity, v1::Similarity* proto);
void ToProto(const Camera& camera, v1::Camera* proto);
void ToProto(const RecordedCamera& recorded, v1::RecordedCamera* proto);
v1::PosesOf ToProto(PosesOf poses_of);

// Writes the upper triangle, row by row; nothing for a matrix of zeros.
void ToProto(const Matrix7d& covariance, google::protobuf::RepeatedField<double>* proto);

// INVALID_ARGUMENT names the field and its limits.
absl::StatusOr<Rigid3d> FromProto(const v1::Rigid& proto);
absl::StatusOr<Similarity3d> FromProto(const v1::Similarity& proto);
absl::StatusOr<Camera> FromProto(const v1::Camera& proto);
absl::StatusOr<RecordedCamera> FromProto(const v1::RecordedCamera& proto);
// Reads an unspecified value as the camera as recorded.
absl::StatusOr<PosesOf> FromProto(v1::PosesOf poses_of);
absl::StatusOr<Matrix7d> FromProto(const google::protobuf::RepeatedField<double>& covariance);

// Returns an error unless the position is finite and within kMaxCoordinate of 0.
absl::Status CheckPosition(const Eigen::Vector3d& position);
// Returns the quaternion made of unit length, if it was nearly so.
absl::StatusOr<Eigen::Quaterniond> CheckRotation(double w, double x, double y, double z);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_GEOMETRY_H_
