// Finds out whether an IMU turns as the camera does, and what is wrong where it does not: axes that
// are exchanged or point the other way, degrees taken for radians, another clock.
#ifndef CORBSLAM_SLAM_INERTIAL_IMU_AXES_H_
#define CORBSLAM_SLAM_INERTIAL_IMU_AXES_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <deque>
#include <optional>
#include <string>

namespace corbslam {

// What the IMU's turning is against the camera's.
struct AxesFit {
  // x_by_camera = camera_from_imu * x_by_imu, both in the axes that the calibration gives the IMU:
  // the identity where the calibration is right.
  Eigen::Quaterniond camera_from_imu = Eigen::Quaterniond::Identity();
  // The camera's rates over the IMU's.
  double scale = 1;
  // Share of the camera's turning that is left over with this fit, and as the calibration has it:
  // 0 where they agree, 1 where they have nothing to do with each other.
  double left_over = 1;
  double left_over_as_calibrated = 1;
};

// Collects rates of turning by frame. Not thread-safe.
class ImuAxes {
 public:
  // Takes the mean rates of turning between two frames, rad/s in the IMU's axes by the calibration:
  // as the camera saw it and as the IMU felt it.
  void Add(const Eigen::Vector3d& by_camera_rps, const Eigen::Vector3d& by_imu_rps);

  // Returns the best rotation and scale (Umeyama, PAMI 1991) for the newest frames; nullopt where
  // they turned too little, or about one axis alone so that some rotations can't be told.
  std::optional<AxesFit> Fit() const;

  // Returns what the fit says is wrong, with what to do; nullopt where nothing is.
  static std::optional<std::string> Describe(const AxesFit& fit);

 private:
  struct Rates {
    Eigen::Vector3d by_camera;
    Eigen::Vector3d by_imu;
  };
  std::deque<Rates> rates_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_IMU_AXES_H_
