// Counts what a robot holds, when somebody asks.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_ROBOT_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_ROBOT_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <string>
#include <utility>
#include <vector>

#include "client_agent/agent/activity_watch.h"
#include "client_agent/agent/agent.h"

namespace corbslam::services {

// Asks Agent::GetStatus, which counts the map's keyframes and points under its reader lock.
// Thread-safe.
class RobotCollector : public prometheus::Collectable {
 public:
  // `agent` and `uplink` (which may be null) are not owned and must outlive it. `activity` may be
  // null: then nothing is said of it.
  RobotCollector(const client_agent::Agent* agent, const Uplink* uplink,
                 std::shared_ptr<const client_agent::ActivityWatch> activity, std::string mission,
                 std::string name)
      : agent_(*agent),
        uplink_(uplink),
        activity_(std::move(activity)),
        mission_(std::move(mission)),
        name_(std::move(name)) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const client_agent::Agent& agent_;
  const Uplink* const uplink_;
  const std::shared_ptr<const client_agent::ActivityWatch> activity_;
  const std::string mission_;
  const std::string name_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_ROBOT_COLLECTOR_H_
