#include "services/programs/robot_observers.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/robot_collector.h"
#include "services/observe/metrics/security_collector.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;

absl::StatusOr<std::unique_ptr<RobotObservers>> RobotObservers::Make(const ObserveFlags& flags,
                                                                     const std::string& mission,
                                                                     const std::string& agent) {
  std::unique_ptr<RobotObservers> observers(new RobotObservers(flags, mission, agent));
  if (!flags.metrics_listen.empty()) observers->metrics_ = std::make_unique<Metrics>();
  if (!flags.trace_file.empty()) {
    const std::string process = absl::StrCat("client_agent ", mission, "/", agent);
    ASSIGN_OR_RETURN(observers->trace_file_, TraceFile::Open(flags.trace_file, process));
    observers->trace_ = std::make_unique<RobotTrace>(observers->trace_file_.get(), mission, agent);
  }
  return observers;
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

void RobotObservers::WatchActivity(std::shared_ptr<const client_agent::ActivityWatch> activity,
                                   bool localise_only) {
  activity_ = std::move(activity);
  localise_only_ = localise_only;
}

Uplink* RobotObservers::Watch(Uplink* uplink) {
  std::vector<UplinkObserver*> observers;
  if (sessions_ != nullptr) observers.push_back(sessions_.get());
  if (metrics_ != nullptr) observers.push_back(&metrics_->robot);
  if (trace_ != nullptr) observers.push_back(trace_.get());
  if (observers.empty() || uplink == nullptr) return uplink;
  uplink_ = MakeObservedUplink(uplink, std::move(observers));
  return uplink_.get();
}

Agent* RobotObservers::Watch(Agent* agent) {
  std::vector<FrameObserver*> observers = {&tally_};
  if (metrics_ != nullptr) observers.push_back(&metrics_->robot);
  if (trace_ != nullptr) observers.push_back(trace_.get());
  agent_ = MakeObservedAgent(agent, std::move(observers));
  return agent_.get();
}

RpcObserver* RobotObservers::OfCalls() { return metrics_ != nullptr ? &metrics_->rpc : nullptr; }

std::unique_ptr<RobotMinutes> RobotObservers::LogEachMinute(const Agent* agent) {
  RobotMinutesOptions options;
  options.who = {.mission = sessions_ != nullptr ? mission_ : "", .agent = name_};
  options.session = OfSessions();
  options.activity = activity_;
  options.localise_only = localise_only_;
  return std::make_unique<RobotMinutes>(agent, &tally_, options);
}

void RobotObservers::LogEvents(std::shared_ptr<client_agent::AgentEvents> events) {
  events_ = std::make_unique<RobotEventLog>(std::move(events),
                                            LogFields{.mission = mission_, .agent = name_});
}

void RobotObservers::SetDropped(uint64_t frames) {
  tally_.SetDropped(frames);
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
