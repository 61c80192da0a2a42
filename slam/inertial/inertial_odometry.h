// Goes on by an IMU where pictures fail: learns from frames that have poses, and says how the
// camera moved since the last of them, and how well that is known.
#ifndef CORBSLAM_SLAM_INERTIAL_INERTIAL_ODOMETRY_H_
#define CORBSLAM_SLAM_INERTIAL_INERTIAL_ODOMETRY_H_

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/inertial/imu.h"
#include "slam/inertial/imu_axes.h"
#include "slam/inertial/imu_buffer.h"
#include "slam/inertial/imu_clock.h"
#include "slam/inertial/inertial_filter.h"
#include "slam/inertial/inertial_motion.h"

namespace corbslam {

// What is known of the IMU.
struct InertialState {
  bool is_ready = false;  // It says how the camera moves.
  std::optional<Down> down;
  ImuBiases biases;
  double late_s = 0;  // How much later than its stamps say the IMU measures, by the calibration.
  double late_sigma_s = 0;
  double noisier = 1;  // InertialFilter::noisier.
};

// Why an IMU is not used, or not as it is.
struct InertialDoubt {
  enum class Kind {
    kMissing,  // No samples come, though the rig has an IMU.
    kGap,      // Samples are missing.
    // Its stamps are off by so much that it could not be used as they are; it goes on with better
    // ones.
    kLate,
    kContradicts,  // What it feels and what the camera sees contradict.
  };
  Kind kind = Kind::kMissing;
  std::string text;  // What was seen, with figures, and what to look at.
};

// The camera is the sensor's, whose poses tracking finds. Not thread-safe.
class InertialOdometry {
 public:
  // What moves for longer without pictures is lost.
  static constexpr int64_t kLongest_ns = 5'000'000'000;

  InertialOdometry(const ImuCalibration& calibration, const Rigid3d& camera_from_recorded);

  // Takes the samples that came with a frame, which are stamped by the camera's clock. Where their
  // time goes back, another drive begins, of which nothing is known.
  void Add(const ImuSamples& samples);

  // Takes the pose that pictures gave of a frame: what the camera moved since the last one, and the
  // covariance of its pose in the axes of the present camera (translation, rotation). Nullopt:
  // nobody knows how it got here.
  void Track(int64_t timestamp_ns, const std::optional<Rigid3d>& camera_from_previous,
             const Matrix6d& covariance);

  // Returns what the camera moved since the last frame that had a pose. Nullopt where it is not
  // known well enough yet or any more, or samples are missing.
  std::optional<InertialMotion> Since(int64_t timestamp_ns) const;

  // Returns the time of the last frame that had a pose; nullopt before the first.
  std::optional<int64_t> last_ns() const {
    return last_.has_value() ? std::optional(last_->timestamp_ns) : std::nullopt;
  }
  InertialState state() const;
  // Returns what is wrong since the last call, each kind once.
  std::vector<InertialDoubt> TakeDoubts() { return std::exchange(doubts_, {}); }

 private:
  struct Seen {
    int64_t timestamp_ns = 0;
    SeenPose pose;
  };

  void ForgetDrive();
  // Where pictures begin anew, the camera is where the IMU takes it to be.
  Rigid3d Anchor(int64_t timestamp_ns);
  void Begin(const Seen& seen);
  void TakePending();
  void Take(const Seen& seen);
  // Returns what was felt on the way; none where samples are missing.
  std::vector<ImuStep> GoOn(int64_t from_ns, int64_t to_ns, InertialFilter& filter) const;
  void CompareTurns(const Seen& before, const Seen& seen, const std::vector<ImuStep>& steps);
  void Judge(const Seen& seen, double distance);
  // Puts stamps right by when the camera turned. Returns false where nothing is wrong with them.
  bool CorrectClock();
  double ShareFar() const;
  bool IsReady() const;
  // Returns whether the IMU seems not to have moved for a while before `until_ns`.
  bool IsStill(int64_t until_ns, const InertialFilter& filter) const;
  void Doubt(InertialDoubt::Kind kind, std::string text);

  const ImuCalibration calibration_;
  const Rigid3d imu_from_camera_;
  ImuBuffer buffer_;  // With the offset added.
  ImuClock clock_;    // As the samples came.
  int64_t offset_ns_ = 0;
  ImuAxes axes_;
  // In a gentle drive a wrong clock makes poses no stranger than chance does, and takes the camera
  // wrong all the same: clocks are compared before the IMU is believed, and some times more.
  static constexpr size_t kLeastTurns = 40;
  size_t turns_ = 0;
  size_t next_clock_check_ = kLeastTurns;
  std::optional<InertialFilter> filter_;
  int64_t filter_ns_ = 0;
  int64_t began_ns_ = 0;
  double least_time_s_ = 1;    // From then until it is ready.
  std::optional<Seen> last_;   // The newest frame that had a pose.
  std::optional<Seen> taken_;  // The newest one that the filter took.
  std::deque<Seen> pending_;   // Those that samples have not come for yet.
  std::deque<bool> was_far_;   // Whether the newest poses were further off than chance.
  std::vector<InertialDoubt> doubts_;
  std::vector<InertialDoubt::Kind> told_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_INERTIAL_INERTIAL_ODOMETRY_H_
