// Exponential and logarithm of SO(3), SE(3) and Sim(3), and their Jacobians.
//
// Tangents are ordered (translation, rotation[, log of scale]). Perturbations act on the left:
// T -> Exp(delta) * T. Sources: Sola et al., "A micro Lie theory for state estimation in robotics",
// 2018; Eade, "Lie Groups for 2D and 3D Transformations", 2013; Barfoot, "State Estimation for
// Robotics", 2017. All functions are pure and smooth across small angles and scales.
#ifndef CORBSLAM_SLAM_GEOMETRY_LIE_H_
#define CORBSLAM_SLAM_GEOMETRY_LIE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slam/geometry/rigid3.h"

namespace corbslam {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

// Returns the matrix of the cross product: Skew(a) * b = a x b.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& rotation_rad);
// Returns a vector of length at most pi.
Eigen::Vector3d LogSO3(const Eigen::Quaterniond& rotation);

Rigid3d ExpSE3(const Vector6d& tangent);
Vector6d LogSE3(const Rigid3d& motion);

Similarity3d ExpSim3(const Vector7d& tangent);
Vector7d LogSim3(const Similarity3d& similarity);

// They satisfy Log(Exp(delta) * Exp(tangent)) = tangent + InverseLeftJacobian(tangent) * delta +
// O(delta^2).
Eigen::Matrix3d InverseLeftJacobianSO3(const Eigen::Vector3d& rotation_rad);
Matrix6d InverseLeftJacobianSE3(const Vector6d& tangent);
// This one is computed from the series of the left Jacobian in the adjoint.
Matrix7d InverseLeftJacobianSim3(const Vector7d& tangent);

// They satisfy T * Exp(delta) * T^-1 = Exp(Adjoint(T) * delta).
Matrix6d AdjointSE3(const Rigid3d& motion);
Matrix7d AdjointSim3(const Similarity3d& similarity);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_GEOMETRY_LIE_H_
