#include "services/viewer/mission_upstream.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kAskPatience = absl::Seconds(10);
constexpr absl::Duration kRobotPatience = absl::Seconds(1);
constexpr int kPageSize = 1000;
// More local maps are not told of one by one.
constexpr int kMaxLocalMaps = 2000;
constexpr int kNewest = 10;

template <typename Field>
void KeepNewest(Field& field) {
  const int old = field.size() - kNewest;
  if (old > 0) field.erase(field.begin(), field.begin() + old);
}

}  // namespace

// A call that ends when its upstream does.
class MissionUpstream::Call {
 public:
  explicit Call(MissionUpstream& upstream, absl::Duration patience = absl::InfiniteDuration())
      : upstream_(upstream) {
    if (patience < absl::InfiniteDuration()) {
      context_.set_deadline(absl::ToChronoTime(absl::Now() + patience));
    }
    absl::MutexLock lock(&upstream_.mutex_);
    upstream_.calls_.insert(&context_);
    if (upstream_.stop_.HasBeenNotified()) context_.TryCancel();
  }
  ~Call() {
    absl::MutexLock lock(&upstream_.mutex_);
    upstream_.calls_.erase(&context_);
  }

  grpc::ClientContext* context() { return &context_; }

 private:
  MissionUpstream& upstream_;
  grpc::ClientContext context_;
};

// Asks one robot how it is; it answers soon or counts as off.
class MissionUpstream::RobotQuestion {
 public:
  RobotQuestion(MissionUpstream& upstream, Robot& robot) : call_(upstream, kRobotPatience) {
    answer_.set_agent(AgentName(upstream.mission_, robot.agent));
    request_.set_mission(MissionName(upstream.mission_));
    robot.stub->async()->GetStatus(call_.context(), &request_, answer_.mutable_status(),
                                   [this](grpc::Status status) {
                                     status_ = std::move(status);
                                     answered_.Notify();
                                   });
  }
  ~RobotQuestion() { answered_.WaitForNotification(); }

  v1::MissionPulse::Robot Await() {
    answered_.WaitForNotification();
    if (status_.ok()) return answer_;
    answer_.clear_status();
    answer_.set_error(status_.error_message());
    return answer_;
  }

 private:
  Call call_;
  v1::GetStatusRequest request_;
  v1::MissionPulse::Robot answer_;
  grpc::Status status_;
  absl::Notification answered_;
};

MissionUpstream::MissionUpstream(std::string mission, std::shared_ptr<StoreRoute> route,
                                 const std::vector<AskedRobot>& robots, MissionFeed* feed,
                                 const UpstreamOptions& options)
    : mission_(std::move(mission)), options_(options), feed_(*feed), route_(std::move(route)) {
  for (const AskedRobot& robot : robots) {
    robots_.push_back({robot.agent, v1::Agent::NewStub(robot.channel)});
  }
  threads_.push_back(StartThread("mission map", [this] {
    Repeat([this](bool& got) {
      const absl::Status status = route_->Ask([&](v1::MapStore::Stub& store) {
        const absl::Status ended = FollowMap(store, got);
        feed_.BeginAnew();
        return ended;
      });
      absl::MutexLock lock(&mutex_);
      map_status_ = status;
    });
  }));
  threads_.push_back(StartThread("mission events", [this] {
    Repeat([this](bool& got) {
      route_->Ask([&](v1::MapStore::Stub& store) { return FollowEvents(store, got); })
          .IgnoreError();
    });
  }));
  threads_.push_back(StartThread("mission pulse", [this] { TakePulses(); }));
}

MissionUpstream::~MissionUpstream() {
  stop_.Notify();
  {
    absl::MutexLock lock(&mutex_);
    for (grpc::ClientContext* call : calls_) call->TryCancel();
  }
  for (std::thread& thread : threads_) thread.join();
}

template <typename Attempt>
void MissionUpstream::Repeat(Attempt attempt) {
  absl::Duration pause = options_.first_pause;
  while (!stop_.HasBeenNotified()) {
    bool got_something = false;
    attempt(got_something);
    if (got_something) pause = options_.first_pause;
    if (stop_.WaitForNotificationWithTimeout(pause)) return;
    pause = std::min(2 * pause, options_.longest_pause);
  }
}

absl::Status MissionUpstream::FollowMap(v1::MapStore::Stub& store, bool& got_something) {
  {
    // A mission of which nothing came yet has nothing to tell, for as long as the stream stands.
    absl::MutexLock lock(&mutex_);
    map_status_ = absl::OkStatus();
  }
  Call call(*this);
  v1::WatchMapRequest request;
  request.set_mission(MissionName(mission_));
  request.set_include_points(true);
  const auto stream = store.WatchMap(call.context(), request);
  v1::WatchMapResponse changes;
  absl::Status applied;
  while (applied.ok() && stream->Read(&changes)) {
    got_something = true;
    applied = feed_.Apply(std::move(changes));
    changes = {};
  }
  if (!applied.ok()) call.context()->TryCancel();
  const absl::Status ended = ToStatus(stream->Finish(), "WatchMap");
  return applied.ok() ? ended : applied;
}

absl::Status MissionUpstream::FollowEvents(v1::MapStore::Stub& store, bool& got_something) {
  Call call(*this);
  v1::WatchEventsRequest request;
  request.set_mission(MissionName(mission_));
  request.set_after_number(feed_.newest_event());
  const auto stream = store.WatchEvents(call.context(), request);
  v1::MissionEvent event;
  while (stream->Read(&event)) {
    got_something = true;
    feed_.AddEvent(std::move(event));
    event = {};
  }
  return ToStatus(stream->Finish(), "WatchEvents");
}

void MissionUpstream::TakePulses() {
  do {
    feed_.SetPulse(TakePulse());
  } while (!stop_.WaitForNotificationWithTimeout(options_.pulse_interval));
}

v1::MissionPulse MissionUpstream::TakePulse() {
  v1::MissionPulse pulse;
  // All robots are asked side by side with the store: some may be off.
  std::vector<std::unique_ptr<RobotQuestion>> questions;
  for (Robot& robot : robots_) questions.push_back(std::make_unique<RobotQuestion>(*this, robot));
  absl::Status status =
      route_->Ask([&](v1::MapStore::Stub& store) { return AskStore(store, pulse); });
  {
    absl::MutexLock lock(&mutex_);
    if (status.ok()) status = map_status_;
  }
  pulse.set_store_answers(status.ok());
  pulse.set_mission_missing(absl::IsNotFound(status));
  if (!status.ok()) pulse.set_store_error(std::string(status.message()));
  for (const auto& question : questions) *pulse.add_robots() = question->Await();
  pulse.set_time_ns(absl::GetCurrentTimeNanos());
  return pulse;
}

absl::Status MissionUpstream::AskStore(v1::MapStore::Stub& store, v1::MissionPulse& pulse) {
  {
    Call call(*this, kAskPatience);
    v1::GetMissionRequest request;
    request.set_name(MissionName(mission_));
    RETURN_IF_ERROR(
        ToStatus(store.GetMission(call.context(), request, pulse.mutable_mission()), "GetMission"));
  }
  {
    Call call(*this, kAskPatience);
    v1::ListAgentsRequest request;
    request.set_parent(MissionName(mission_));
    request.set_page_size(kPageSize);
    v1::ListAgentsResponse response;
    RETURN_IF_ERROR(ToStatus(store.ListAgents(call.context(), request, &response), "ListAgents"));
    pulse.mutable_agents()->Swap(response.mutable_agents());
  }
  {
    Call call(*this, kAskPatience);
    v1::GetStatisticsRequest request;
    request.set_mission(MissionName(mission_));
    v1::GetStatisticsResponse response;
    RETURN_IF_ERROR(
        ToStatus(store.GetStatistics(call.context(), request, &response), "GetStatistics"));
    pulse.mutable_statistics()->Swap(response.mutable_mission());
    KeepNewest(*pulse.mutable_statistics()->mutable_merge_ms());
    KeepNewest(*pulse.mutable_statistics()->mutable_adjustments());
  }
  v1::ListLocalMapsRequest request;
  request.set_parent(MissionName(mission_));
  request.set_page_size(kPageSize);
  do {
    Call call(*this, kAskPatience);
    v1::ListLocalMapsResponse response;
    RETURN_IF_ERROR(
        ToStatus(store.ListLocalMaps(call.context(), request, &response), "ListLocalMaps"));
    pulse.mutable_local_maps()->MergeFrom(response.local_maps());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty() && pulse.local_maps_size() < kMaxLocalMaps);
  return absl::OkStatus();
}

}  // namespace corbslam::services
