// Rigid motions and similarities of 3-space, spelled target_from_source: x_target = T * x_source.
#ifndef CORBSLAM_SLAM_GEOMETRY_RIGID3_H_
#define CORBSLAM_SLAM_GEOMETRY_RIGID3_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace corbslam {

// Maps x_target = rotation * x_source + translation. Whoever sets the quaternion keeps it of unit
// length; products renormalise. Translations are in metres where the map is metric.
struct Rigid3d {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  static Rigid3d Identity() { return {}; }

  Rigid3d Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation)};
  }
  friend Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a) {
    return {(c_from_b.rotation * b_from_a.rotation).normalized(),
            c_from_b.rotation * b_from_a.translation + c_from_b.translation};
  }
  friend Eigen::Vector3d operator*(const Rigid3d& b_from_a, const Eigen::Vector3d& x_in_a) {
    return b_from_a.rotation * x_in_a + b_from_a.translation;
  }
};

// Maps x_target = scale * rotation * x_source + translation, scale > 0 (1 between metric maps).
struct Similarity3d {
  double scale = 1.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  static Similarity3d Identity() { return {}; }
  static Similarity3d FromRigid(const Rigid3d& rigid) {
    return {1.0, rigid.rotation, rigid.translation};
  }

  // Returns the rigid motion of a camera whose frame is rescaled to its target's units: (R, t /
  // scale). Projections are the same.
  Rigid3d ToRigid() const { return {rotation, translation / scale}; }

  Similarity3d Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {1.0 / scale, inverse, -(inverse * translation) / scale};
  }
  friend Similarity3d operator*(const Similarity3d& c_from_b, const Similarity3d& b_from_a) {
    return {c_from_b.scale * b_from_a.scale, (c_from_b.rotation * b_from_a.rotation).normalized(),
            c_from_b.scale * (c_from_b.rotation * b_from_a.translation) + c_from_b.translation};
  }
  friend Eigen::Vector3d operator*(const Similarity3d& b_from_a, const Eigen::Vector3d& x_in_a) {
    return b_from_a.scale * (b_from_a.rotation * x_in_a) + b_from_a.translation;
  }
};

// Returns the angle of the rotation, radians, 0 to pi.
double RotationAngle(const Eigen::Quaterniond& rotation);

// Returns the camera's centre in the frame that `camera_from_frame` comes from.
inline Eigen::Vector3d CameraCentre(const Rigid3d& camera_from_frame) {
  return -(camera_from_frame.rotation.conjugate() * camera_from_frame.translation);
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_GEOMETRY_RIGID3_H_
