// Who watches a robot at work: its log, and as the flags say metrics and a trace.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_OBSERVERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_OBSERVERS_H_

#include <prometheus/registry.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "services/client/reachability/cause.h"
#include "services/observe/event_log/uplink_log.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/observe/metrics/robot_metrics.h"
#include "services/observe/metrics/rpc_metrics.h"
#include "services/observe/tracing/robot_trace.h"
#include "services/programs/observe_flags.h"

namespace corbslam {

// One thread. Outlives the agent, and goes before the uplink that it was given.
class RobotObservers {
 public:
  // UNAVAILABLE where the trace file can't be written.
  static absl::StatusOr<std::unique_ptr<RobotObservers>> Make(const ObserveFlags& flags,
                                                              const std::string& mission,
                                                              const std::string& agent);

  // Before the uplink is watched: its sessions with this store are logged.
  void LogSessions(const ServerTarget& store);
  // Why no session stands, OK while one does; null without LogSessions.
  std::function<absl::Status()> OfSessions() const;

  // What they are given (null too), or the same watched, which then is owned here.
  Uplink* Watch(Uplink* uplink);
  Agent* Watch(Agent* agent);
  // For ServerOptions.
  RpcObserver* OfCalls();
  void SetDropped(uint64_t frames);
  // Serves the metrics, and announces where; null where none are wanted. To be destroyed before
  // `agent` and `uplink` (which may be null).
  absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Serve(const Agent* agent, const Uplink* uplink);

 private:
  struct Metrics {
    std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
    RpcMetrics rpc{*registry};
    RobotMetrics robot{*registry};
  };

  RobotObservers(const ObserveFlags& flags, std::string mission, std::string agent)
      : flags_(flags), mission_(std::move(mission)), name_(std::move(agent)) {}

  const ObserveFlags flags_;
  const std::string mission_;
  const std::string name_;
  std::unique_ptr<Metrics> metrics_;
  std::unique_ptr<TraceFile> trace_file_;
  std::unique_ptr<RobotTrace> trace_;
  std::unique_ptr<UplinkLog> sessions_;
  std::unique_ptr<Uplink> uplink_;
  std::unique_ptr<Agent> agent_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_OBSERVERS_H_
