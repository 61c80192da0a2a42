// What a program adds to a robot in its process: it hears what becomes of each frame, as watchers
// of the robot's service do.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_COMPANION_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_COMPANION_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "client_agent/agent/agent.h"
#include "client_agent/agent/agent_orders.h"
#include "client_agent/tracking/tracking_result.h"
#include "corbslam/v1/agent_service.pb.h"
#include "services/programs/robot/agent_run.h"
#include "slam/camera/recorded_camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::services {

// A robot that has begun. All of it lives until OnEnd has returned.
struct RobotView {
  const client_agent::Agent* agent = nullptr;
  std::string name;
  RecordedCamera recorded;
  std::shared_ptr<client_agent::AgentOrders> orders;
  bool has_store = false;
  // Returns OK while a session with the store stands, else why not; null without a store.
  std::function<absl::Status()> session;
};

class RobotCompanion {
 public:
  virtual ~RobotCompanion() = default;
  // Called before the source is opened, which may wait for its camera for long.
  virtual absl::Status Prepare() = 0;
  // Called before the first frame.
  virtual absl::Status Begin(const RobotView& robot) = 0;
  // Called from the thread that tracks, after each frame; it must return at once.
  virtual void OnFrame(const client_agent::TrackingResult& result, const FrameMoment& moment) = 0;
  // Called when no frame comes any more.
  virtual void OnEnd() = 0;
  // Returns what the stamps of the source's frames count.
  virtual v1::AgentClock clock() const = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_COMPANION_H_
