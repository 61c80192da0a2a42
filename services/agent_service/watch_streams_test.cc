// Tests what planners watch beside the pose, through the real stubs in one process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "services/agent_service/agent_service.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

using client_agent::Agent;
using client_agent::AgentEvents;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::GuardedMap;
using client_agent::LinkEvent;
using client_agent::NearMap;
using client_agent::NearMapLimits;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::TrajectoryPose;
using ::testing::HasSubstr;

constexpr LocalMapId kOwn = {0xabc};
constexpr LocalMapId kOther = {0xdef};

// An agent that is all map: own points and another's at x = 0, 1, 2, ... 99, in turns, and a
// keyframe of each at x = 3. Its camera stands at the origin.
class MapAgent : public Agent {
 public:
  MapAgent() {
    map_.Write([](Map& map) {
      for (uint32_t i = 0; i < 100; ++i) {
        MapPoint point;
        point.id = {i % 2 == 0 ? kOwn : kOther, i};
        point.position_in_map = {1.0 * i, 0, 0};
        map.AddPoint(std::move(point));
      }
      for (const LocalMapId id : {kOwn, kOther}) {
        Keyframe keyframe;
        keyframe.payload = MakeKeyframePayload({id, 7}, 0, 0, std::make_shared<const Camera>(), {});
        keyframe.camera_from_map.translation = {-3, 0, 0};
        map.AddKeyframe(std::move(keyframe));
      }
    });
  }

  absl::StatusOr<TrackingResult> Track(const SensorImages&) override { return TrackingResult(); }
  absl::Status UsePause() override { return absl::OkStatus(); }
  void BeginLocalMap() override {}
  void Step() override {}
  absl::Status Finish(absl::Duration) override { return absl::OkStatus(); }
  AgentStatus GetStatus() const override { return {}; }
  AgentTimings GetTimings() const override { return {}; }
  std::vector<TrajectoryPose> LocalTrajectory() const override { return {}; }
  Map CopyMap() const override { return {}; }
  std::optional<NearMap> GetNearMap(const NearMapLimits& limits) const override {
    if (!has_pose) return std::nullopt;
    NearMap near = FindNearMap(map_, {0, 0, 0}, limits);
    near.timestamp_ns = 5;
    return near;
  }

  std::atomic<bool> has_pose = true;

 private:
  GuardedMap map_{kOwn};
};

class WatchStreamsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = Server::Start("", {&service_});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::Agent::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  void Track(TrackingState state = TrackingState::kTracking) {
    TrackingResult result;
    result.timestamp_ns = ++time_ns_;
    result.state = state;
    result.local_map = kOwn;
    result.epoch = 1;
    service_.OnFrame(result, 0);
  }
  std::string RefusalOf(const v1::WatchAgentMapRequest& request) {
    grpc::ClientContext context;
    const auto stream = stub_->WatchMap(&context, request);
    v1::WatchAgentMapResponse response;
    EXPECT_FALSE(stream->Read(&response));
    const grpc::Status status = stream->Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    return status.error_message();
  }

  int64_t time_ns_ = 0;
  MapAgent agent_;
  std::shared_ptr<AgentEvents> events_ = std::make_shared<AgentEvents>();
  AgentService service_{&agent_, nullptr, {.mission = "", .agent = "alpha", .events = events_}};
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::Agent::Stub> stub_;
};

TEST_F(WatchStreamsTest, EventsComeAsTheyWereAndAsTheyCome) {
  Track();
  Track(TrackingState::kLost);
  grpc::ClientContext context;
  const auto stream = stub_->WatchEvents(&context, {});
  v1::AgentEvent event;
  ASSERT_TRUE(stream->Read(&event));
  EXPECT_EQ(event.number(), 1u);
  EXPECT_EQ(event.kind(), v1::AGENT_EVENT_KIND_LOCAL_MAP_BEGUN);
  EXPECT_EQ(event.local_map(), "0000000000000abc");
  EXPECT_EQ(event.timestamp_ns(), 1);
  EXPECT_EQ(event.epoch(), 1u);
  EXPECT_GT(event.time_ns(), 0);
  ASSERT_TRUE(stream->Read(&event));
  EXPECT_EQ(event.kind(), v1::AGENT_EVENT_KIND_LOST);
  events_->NoteLink(LinkEvent::kMissionDeleted, kOwn);
  ASSERT_TRUE(stream->Read(&event));
  EXPECT_EQ(event.number(), 3u);
  EXPECT_EQ(event.kind(), v1::AGENT_EVENT_KIND_MISSION_DELETED);
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(WatchStreamsTest, EventsGoOnAfterANumber) {
  Track();
  for (const LinkEvent event : {LinkEvent::kMerged, LinkEvent::kSplit, LinkEvent::kMerged}) {
    events_->NoteLink(event, kOwn);
  }
  grpc::ClientContext context;
  v1::WatchAgentEventsRequest request;
  request.set_after_number(2);
  const auto stream = stub_->WatchEvents(&context, request);
  v1::AgentEvent event;
  ASSERT_TRUE(stream->Read(&event));
  EXPECT_EQ(event.number(), 3u);
  EXPECT_EQ(event.kind(), v1::AGENT_EVENT_KIND_SPLIT);
  ASSERT_TRUE(stream->Read(&event));
  EXPECT_EQ(event.kind(), v1::AGENT_EVENT_KIND_MERGED);
}

TEST_F(WatchStreamsTest, StreamsEndInGoodOrderWhereTheRobotsDriveDoes) {
  Track();
  grpc::ClientContext events_context;
  const auto events = stub_->WatchEvents(&events_context, {});
  grpc::ClientContext poses_context;
  const auto poses = stub_->WatchPose(&poses_context, {});
  grpc::ClientContext map_context;
  const auto map = stub_->WatchMap(&map_context, {});
  v1::WatchPoseResponse pose;
  ASSERT_TRUE(poses->Read(&pose));
  service_.OnEnd();
  v1::AgentEvent event;
  while (events->Read(&event)) {
  }
  EXPECT_EQ(event.kind(), v1::AGENT_EVENT_KIND_ENDED);
  EXPECT_TRUE(events->Finish().ok());
  EXPECT_FALSE(poses->Read(&pose));
  EXPECT_TRUE(poses->Finish().ok());
  v1::WatchAgentMapResponse near;
  while (map->Read(&near)) {
  }
  EXPECT_TRUE(map->Finish().ok());

  // Whoever comes later is told the same.
  grpc::ClientContext late_context;
  const auto late = stub_->WatchPose(&late_context, {});
  ASSERT_TRUE(late->Read(&pose));
  EXPECT_EQ(pose.timestamp_ns(), 1);
  EXPECT_FALSE(late->Read(&pose));
  EXPECT_TRUE(late->Finish().ok());
  v1::WatchAgentEventsRequest request;
  request.set_after_number(event.number());
  events_->NoteLink(LinkEvent::kMerged, kOwn);
  grpc::ClientContext again_context;
  const auto again = stub_->WatchEvents(&again_context, request);
  EXPECT_FALSE(again->Read(&event));
  EXPECT_TRUE(again->Finish().ok());
}

TEST_F(WatchStreamsTest, APoseSaysItsClockAndHowOldItIs) {
  TrackingResult result;
  result.timestamp_ns = 1;
  service_.OnFrame(result, 0, std::chrono::steady_clock::now() - std::chrono::seconds(3));
  grpc::ClientContext context;
  const auto stream = stub_->WatchPose(&context, {});
  v1::WatchPoseResponse pose;
  ASSERT_TRUE(stream->Read(&pose));
  EXPECT_GE(pose.age_s(), 3);
  EXPECT_LT(pose.age_s(), 60);
  EXPECT_EQ(pose.clock(), v1::AGENT_CLOCK_RECORDED);
  context.TryCancel();
  stream->Finish();
}

TEST_F(WatchStreamsTest, TheMapAroundThePoseComesWithAFrame) {
  grpc::ClientContext context;
  v1::WatchAgentMapRequest request;
  request.set_max_rate_hz(10);
  request.set_radius_m(5.5);
  const auto stream = stub_->WatchMap(&context, request);
  Track();
  v1::WatchAgentMapResponse map;
  ASSERT_TRUE(stream->Read(&map));
  EXPECT_EQ(map.local_map(), "0000000000000abc");
  EXPECT_EQ(map.timestamp_ns(), 5);
  ASSERT_EQ(map.centre_size(), 3);
  ASSERT_EQ(map.own_points_size(), 9);  // At 0, 2 and 4.
  EXPECT_EQ(map.own_points(3), 2);
  ASSERT_EQ(map.shared_points_size(), 9);  // At 1, 3 and 5.
  EXPECT_EQ(map.shared_points(0), 1);
  EXPECT_FALSE(map.truncated());
  ASSERT_EQ(map.keyframes_size(), 2);
  EXPECT_EQ(map.keyframes(0).index(), 7u);
  EXPECT_EQ(map.keyframes(0).local_from_camera().translation(0), 3);
  EXPECT_NE(map.keyframes(0).shared(), map.keyframes(1).shared());
  const v1::NearKeyframe& shared = map.keyframes(map.keyframes(0).shared() ? 0 : 1);
  EXPECT_EQ(shared.local_map(), "0000000000000def");
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(WatchStreamsTest, TheNearestPointsAreKept) {
  Track();
  grpc::ClientContext context;
  v1::WatchAgentMapRequest request;
  request.set_radius_m(50);
  request.set_max_points(4);
  const auto stream = stub_->WatchMap(&context, request);
  v1::WatchAgentMapResponse map;
  ASSERT_TRUE(stream->Read(&map));
  EXPECT_EQ(map.own_points_size() + map.shared_points_size(), 12);
  EXPECT_EQ(map.shared_points(3), 3);
  EXPECT_TRUE(map.truncated());
}

TEST_F(WatchStreamsTest, NoMapComesBeforeAPoseAndTheRateIsKept) {
  agent_.has_pose = false;
  Track(TrackingState::kNotInitialised);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(500));
  v1::WatchAgentMapRequest request;
  request.set_max_rate_hz(0.1);
  const auto stream = stub_->WatchMap(&context, request);
  Track(TrackingState::kNotInitialised);
  // The next look is due in ten seconds.
  agent_.has_pose = true;
  Track();
  v1::WatchAgentMapResponse map;
  int maps = 0;
  while (stream->Read(&map)) ++maps;
  EXPECT_LE(maps, 1);
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(WatchStreamsTest, RefusesLimitsThatAreNone) {
  v1::WatchAgentMapRequest request;
  request.set_radius_m(0.5);
  EXPECT_THAT(RefusalOf(request), HasSubstr("radius_m is 0.5, must be 0 or in [1, 1000]"));
  request.set_radius_m(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(RefusalOf(request), HasSubstr("radius_m"));
  request.set_radius_m(20);
  request.set_max_rate_hz(11);
  EXPECT_THAT(RefusalOf(request), HasSubstr("max_rate_hz is 11, must be 0 or in [0.1, 10]"));
  request.set_max_rate_hz(1);
  request.set_max_points(200'001);
  EXPECT_THAT(RefusalOf(request), HasSubstr("max_points is 200001, must be at most 200000"));
}

TEST(NoEventsTest, AnAgentThatKeepsNoneSaysSo) {
  MapAgent agent;
  AgentService service(&agent, nullptr, {.mission = "", .agent = "alpha"});
  auto server = *Server::Start("", {&service});
  const auto stub = v1::Agent::NewStub(server->InProcessChannel());
  grpc::ClientContext context;
  const auto stream = stub->WatchEvents(&context, {});
  v1::AgentEvent event;
  EXPECT_FALSE(stream->Read(&event));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNIMPLEMENTED);
  server->Shutdown(absl::ZeroDuration());
}

}  // namespace
}  // namespace corbslam::services
