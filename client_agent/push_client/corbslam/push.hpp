// C++ over corbslam/push.h: a connection that closes itself, and errors as a type. C++17, no
// library of its own; link corbslam::push.
#ifndef CORBSLAM_PUSH_HPP_
#define CORBSLAM_PUSH_HPP_

#include <array>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "corbslam/push.h"

namespace corbslam {

// Thrown where the connection can't go on, and where an argument is wrong.
class PushError : public std::runtime_error {
 public:
  PushError(corbslam_push_status status, const std::string& text)
      : std::runtime_error(text), status_(status) {}
  corbslam_push_status status() const { return status_; }

 private:
  corbslam_push_status status_;
};

class PushConnection {
 public:
  static constexpr size_t kTextBytes = 2100;

  // Throws PushError where the robot is not there within options.timeout_ms or refuses the driver.
  explicit PushConnection(const corbslam_push_options& options) {
    std::array<char, kTextBytes> error = {};
    corbslam_push* opened = nullptr;
    const auto status = corbslam_push_connect(&options, &opened, error.data(), error.size());
    if (status != CORBSLAM_PUSH_OK) throw PushError(status, error.data());
    connection_.reset(opened);
  }

  // Returns nullopt where no slot was free in time: drop this frame.
  std::optional<corbslam_push_slot> Begin(int32_t timeout_ms) {
    corbslam_push_slot slot = {};
    if (!Succeeds(corbslam_push_begin(get(), timeout_ms, &slot))) return std::nullopt;
    return slot;
  }
  void Commit(const corbslam_push_slot& slot, int64_t timestamp_ns) {
    Succeeds(corbslam_push_commit(get(), slot.index, timestamp_ns));
  }
  void Cancel(const corbslam_push_slot& slot) { Succeeds(corbslam_push_cancel(get(), slot.index)); }
  // Copies both pictures, whose rows follow each other. Returns false where no slot was free in
  // time.
  bool Push(const void* first, const void* second, int64_t timestamp_ns, int32_t timeout_ms) {
    return Succeeds(corbslam_push_frame(get(), first, 0, second, 0, timestamp_ns, timeout_ms));
  }
  // Gives the robot what an IMU measured (corbslam_push_imu). Returns false where it takes nothing at
  // the moment. Throws PushError where it takes no samples at all.
  bool PushImu(const corbslam_push_imu_sample* samples, uint32_t count) {
    return Succeeds(corbslam_push_imu(get(), samples, count));
  }
  bool PushImu(const corbslam_push_imu_sample& sample) { return PushImu(&sample, 1); }
  // Returns nullopt where none came in time.
  std::optional<corbslam_push_pose> NextPose(int32_t timeout_ms) {
    corbslam_push_pose pose = {};
    if (!Succeeds(corbslam_push_next_pose(get(), timeout_ms, &pose))) return std::nullopt;
    return pose;
  }
  corbslam_push* get() const { return connection_.get(); }

 private:
  struct Close {
    void operator()(corbslam_push* connection) const { corbslam_push_close(connection); }
  };

  // Returns false after a timeout, and throws what else there is.
  bool Succeeds(corbslam_push_status status) const {
    if (status == CORBSLAM_PUSH_OK) return true;
    if (status == CORBSLAM_PUSH_TIMEOUT) return false;
    std::array<char, kTextBytes> error = {};
    corbslam_push_error(get(), error.data(), error.size());
    throw PushError(status, error.data());
  }

  std::unique_ptr<corbslam_push, Close> connection_;
};

}  // namespace corbslam

#endif  // CORBSLAM_PUSH_HPP_
