#include "services/programs/robot_observers.h"

#include <vector>

#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/robot_collector.h"
#include "services/observe/metrics/security_collector.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;

RobotObservers::RobotObservers(const ObserveFlags& flags, std::string mission, std::string agent)
    : flags_(flags), mission_(std::move(mission)), name_(std::move(agent)) {
  if (!flags.metrics_listen.empty()) metrics_ = std::make_unique<Metrics>();
}

void RobotObservers::LogSessions(const ServerTarget& store, bool localise_only) {
  UplinkLogOptions options;
  options.localise_only = localise_only;
  sessions_ = std::make_unique<UplinkLog>(
      LogFields{.mission = mission_, .agent = name_},
      [store](const absl::Status& seen) { return ExplainFailure(store, seen); }, options);
}

std::function<absl::Status()> RobotObservers::OfSessions() const {
  if (sessions_ == nullptr) return nullptr;
  return [this] { return sessions_->status(); };
}

Uplink* RobotObservers::Watch(Uplink* uplink) {
  std::vector<UplinkObserver*> observers;
  if (sessions_ != nullptr) observers.push_back(sessions_.get());
  if (metrics_ != nullptr) observers.push_back(&metrics_->robot);
  if (observers.empty() || uplink == nullptr) return uplink;
  uplink_ = MakeObservedUplink(uplink, std::move(observers));
  return uplink_.get();
}

Agent* RobotObservers::Watch(Agent* agent) {
  if (metrics_ == nullptr) return agent;
  agent_ = MakeObservedAgent(agent, {&metrics_->robot});
  return agent_.get();
}

RpcObserver* RobotObservers::OfCalls() { return metrics_ != nullptr ? &metrics_->rpc : nullptr; }

void RobotObservers::LogEvents(std::shared_ptr<client_agent::AgentEvents> events) {
  events_ = std::make_unique<RobotEventLog>(std::move(events),
                                            LogFields{.mission = mission_, .agent = name_});
}

void RobotObservers::SetDropped(uint64_t frames) {
  if (metrics_ != nullptr) metrics_->robot.SetDropped(frames);
}

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> RobotObservers::Serve(
    const Agent* agent, const Uplink* uplink, std::vector<WatchedFolder> folders) {
  if (metrics_ == nullptr) return nullptr;
  ASSIGN_OR_RETURN(auto endpoint,
                   MetricsEndpoint::Start(
                       flags_.metrics_listen,
                       {std::make_shared<ProcessCollector>("client_agent"),
                        std::make_shared<SecurityCollector>(), metrics_->registry,
                        std::make_shared<RobotCollector>(agent, uplink, activity_, mission_, name_),
                        std::make_shared<DiskCollector>(std::move(folders))}));
  AnnounceMetrics(endpoint->address());
  return endpoint;
}

}  // namespace corbslam::services
