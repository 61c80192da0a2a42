#include "client_agent/agent/agent_orders.h"

#include <opencv2/imgproc.hpp>

#include "slam/sensor/image_check.h"

namespace corbslam::client_agent {

absl::Status AgentOrders::CheckMask(const PictureMask& mask) const {
  absl::MutexLock lock(&mutex_);
  if (camera_.width_px == 0) return absl::OkStatus();
  if (recorded_.width_px > 0 && corbslam::CheckMask(mask, recorded_).ok()) return absl::OkStatus();
  return corbslam::CheckMask(mask, camera_);
}

absl::Status AgentOrders::SetMask(const PictureMask& mask) {
  absl::MutexLock lock(&mutex_);
  const bool is_scaled = recorded_.width_px > 0 && !corbslam::CheckMask(mask, camera_).ok();
  if (const absl::Status fits = corbslam::CheckMask(mask, is_scaled ? recorded_ : camera_);
      !fits.ok()) {
    return fits;
  }
  if (is_scaled) {
    // What the robot's own body covers stays so: grey levels in between would be taken as free.
    cv::resize(mask, next_.mask.emplace(), {camera_.width_px, camera_.height_px}, 0, 0,
               cv::INTER_NEAREST);
  } else {
    next_.mask = mask;
  }
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
