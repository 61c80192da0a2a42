// Makes what watches a robot at work: its log and, if the flags say so, metrics.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_OBSERVERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_OBSERVERS_H_

#include <prometheus/registry.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "services/client/reachability/cause.h"
#include "services/observe/event_log/robot_events.h"
#include "services/observe/event_log/uplink_log.h"
#include "services/observe/metrics/disk_collector.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/observe/metrics/robot_metrics.h"
#include "services/observe/metrics/rpc_metrics.h"
#include "services/programs/observe_flags.h"

namespace corbslam::services {

// Watches one robot. One thread uses it. It outlives the agent, and is destroyed before the uplink
// that it was given.
class RobotObservers {
 public:
  RobotObservers(const ObserveFlags& flags, std::string mission, std::string agent);

  // Makes the sessions with this store be logged. The caller does so before the uplink is watched.
  void LogSessions(const ServerTarget& store, bool localise_only);
  // Returns a function that says why no session stands, or OK while one does; null without
  // LogSessions.
  std::function<absl::Status()> OfSessions() const;

  // Makes metrics say what the robot is doing.
  void WatchActivity(std::shared_ptr<const client_agent::ActivityWatch> activity) {
    activity_ = std::move(activity);
  }

  // Each returns what it is given (null too), or a watched form of it, which the observers own.
  Uplink* Watch(Uplink* uplink);
  client_agent::Agent* Watch(client_agent::Agent* agent);
  // Returns the observer for ServerOptions.
  RpcObserver* OfCalls();
  // Logs what fusion does to the robot, which its link notes here.
  void LogEvents(std::shared_ptr<client_agent::AgentEvents> events);
  void SetDropped(uint64_t frames);
  // Serves the metrics, those of the folders' disks among them, and announces the address; null if
  // none are wanted. The result must be destroyed before `agent` and `uplink` (which may be null).
  absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Serve(const client_agent::Agent* agent,
                                                         const Uplink* uplink,
                                                         std::vector<WatchedFolder> folders);

 private:
  struct Metrics {
    std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
    RpcMetrics rpc{*registry};
    RobotMetrics robot{*registry};
  };

  const ObserveFlags flags_;
  const std::string mission_;
  const std::string name_;
  std::shared_ptr<const client_agent::ActivityWatch> activity_;
  std::unique_ptr<Metrics> metrics_;
  std::unique_ptr<UplinkLog> sessions_;
  std::unique_ptr<RobotEventLog> events_;
  std::unique_ptr<Uplink> uplink_;
  std::unique_ptr<client_agent::Agent> agent_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_OBSERVERS_H_
