// Tests the robot's own service, through the real stubs in one process.
#include "services/agent_service/agent_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "services/server/server.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::TrajectoryPose;

namespace {

using ::testing::HasSubstr;

class FakeAgent : public Agent {
 public:
  absl::StatusOr<TrackingResult> Track(const SensorImages&) override { return TrackingResult(); }
  absl::Status UsePause() override { return absl::OkStatus(); }
  void BeginLocalMap() override {}
  void Step() override {}
  absl::Status Finish(absl::Duration) override { return absl::OkStatus(); }
  AgentStatus GetStatus() const override {
    AgentStatus status;
    status.state = TrackingState::kLost;
    status.local_map = {0xabc};
    status.frames = 12;
    status.lost = 3;
    status.keyframes = 4;
    status.global_from_local = Similarity3d::Identity();
    status.upload.batches = 6;
    status.upload.frames = 60;
    status.upload.memory_bytes = 70;
    status.upload.spool_bytes = 800;
    status.upload.room = absl::ResourceExhaustedError("full");
    status.upload.loss = absl::DataLossError("gone");
    status.upload.lost_local_maps = 2;
    status.upload.held_back.items = {1, 20, 300, 4000};
    status.upload.held_back.waited[1] = absl::Seconds(2.5);
    return status;
  }
  AgentTimings GetTimings() const override { return {}; }
  std::vector<TrajectoryPose> LocalTrajectory() const override {
    std::vector<TrajectoryPose> poses;
    for (int i = 0; i < 2500; ++i) {
      poses.push_back({i * 1000, {0xabc}, {Eigen::Quaterniond::Identity(), {0.1 * i, 0, 0}}});
    }
    return poses;
  }
  Map CopyMap() const override { return {}; }
  std::optional<client_agent::NearMap> GetNearMap(
      const client_agent::NearMapLimits&) const override {
    return std::nullopt;
  }
};

class AgentServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = Server::Start("", {&service_});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::Agent::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  void Track(int64_t time_ns, TrackingState state = TrackingState::kTracking) {
    TrackingResult result;
    result.timestamp_ns = time_ns;
    result.state = state;
    result.local_map = {0xabc};
    result.camera_from_local.translation = {0, 0, -2};
    service_.OnFrame(result, 5);
  }

  FakeAgent agent_;
  // The recorded camera is turned by 0.2 rad against the camera whose poses the agent knows; the
  // body is 1 m above.
  static RecordedCamera MakeRecorded() {
    RecordedCamera recorded;
    recorded.camera_from_recorded.rotation = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY());
    recorded.body_from_recorded = Rigid3d{Eigen::Quaterniond::Identity(), {0, 1, 0}};
    return recorded;
  }

  std::shared_ptr<client_agent::AgentOrders> orders_ =
      std::make_shared<client_agent::AgentOrders>();
  AgentService service_{&agent_,
                        nullptr,
                        {.mission = "m",
                         .agent = "alpha",
                         .recorded_camera = MakeRecorded(),
                         .session = [] { return absl::AlreadyExistsError("another alpha"); },
                         .orders = orders_}};
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::Agent::Stub> stub_;
};

TEST_F(AgentServiceTest, TellsHowItIs) {
  Track(1);
  grpc::ClientContext context;
  v1::AgentStatus status;
  ASSERT_TRUE(stub_->GetStatus(&context, {}, &status).ok());
  EXPECT_EQ(status.mission(), "missions/m");
  EXPECT_EQ(status.agent(), "alpha");
  EXPECT_EQ(status.state(), v1::TRACKING_STATE_LOST);
  EXPECT_EQ(status.local_map(), "0000000000000abc");
  EXPECT_EQ(status.frames(), 12u);
  EXPECT_EQ(status.dropped(), 5u);
  EXPECT_TRUE(status.has_global_from_local());
  EXPECT_EQ(status.outbox_batches(), 6u);
  EXPECT_EQ(status.outbox_frames(), 60u);
  EXPECT_EQ(status.outbox_memory_bytes(), 70u);
  EXPECT_EQ(status.outbox_spool_bytes(), 800u);
  EXPECT_EQ(status.outbox_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(status.loss_code(), grpc::StatusCode::DATA_LOSS);
  EXPECT_EQ(status.lost_local_maps(), 2u);
  ASSERT_EQ(status.held_back_size(), 4);
  EXPECT_EQ(status.held_back(0).kind(), v1::UPDATE_KIND_POSES);
  EXPECT_EQ(status.held_back(0).items(), 1u);
  EXPECT_EQ(status.held_back(1).kind(), v1::UPDATE_KIND_KEYFRAMES);
  EXPECT_EQ(status.held_back(1).items(), 20u);
  EXPECT_EQ(status.held_back(1).waited_s(), 2.5);
  EXPECT_EQ(status.held_back(2).kind(), v1::UPDATE_KIND_POINTS);
  EXPECT_EQ(status.held_back(3).kind(), v1::UPDATE_KIND_LIGHT_POINTS);
  EXPECT_EQ(status.held_back(3).items(), 4000u);
  EXPECT_FALSE(status.connected());
  EXPECT_EQ(status.session_code(), grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(status.session_message(), "another alpha");
}

TEST_F(AgentServiceTest, RefusesWhoeverExpectsAnotherMission) {
  grpc::ClientContext context;
  v1::GetStatusRequest request;
  request.set_mission("missions/other");
  v1::AgentStatus status;
  EXPECT_EQ(stub_->GetStatus(&context, request, &status).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(AgentServiceTest, WatchersGetTheNewestPose) {
  Track(1000);
  grpc::ClientContext context;
  const auto stream = stub_->WatchPose(&context, {});
  v1::WatchPoseResponse pose;
  ASSERT_TRUE(stream->Read(&pose));
  EXPECT_EQ(pose.timestamp_ns(), 1000);
  EXPECT_EQ(pose.local_from_camera().translation(2), 2);
  Track(2000, TrackingState::kLost);
  ASSERT_TRUE(stream->Read(&pose));
  EXPECT_EQ(pose.timestamp_ns(), 2000);
  EXPECT_EQ(pose.state(), v1::TRACKING_STATE_LOST);
  EXPECT_FALSE(pose.has_local_from_camera());
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(AgentServiceTest, OrdersReachTheRobot) {
  const auto call = [this](auto method, const auto& request, auto&& response) {
    grpc::ClientContext context;
    return (*stub_.*method)(&context, request, &response);
  };
  orders_->SetCamera({.width_px = 64, .height_px = 48});
  EXPECT_TRUE(
      call(&v1::Agent::Stub::OpenNewMap, v1::OpenNewMapRequest(), v1::OpenNewMapResponse()).ok());
  EXPECT_TRUE(orders_->Take().open_local_map);
  EXPECT_EQ(
      call(&v1::Agent::Stub::PauseMapping, v1::PauseMappingRequest(), v1::PauseMappingResponse())
          .error_code(),
      grpc::StatusCode::FAILED_PRECONDITION)
      << "the new local map is empty";
  orders_->NoteTracked();
  EXPECT_TRUE(
      call(&v1::Agent::Stub::PauseMapping, v1::PauseMappingRequest(), v1::PauseMappingResponse())
          .ok());
  EXPECT_TRUE(orders_->Take().mapping_paused);
  EXPECT_EQ(call(&v1::Agent::Stub::OpenNewMap, v1::OpenNewMapRequest(), v1::OpenNewMapResponse())
                .error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_TRUE(
      call(&v1::Agent::Stub::ResumeMapping, v1::ResumeMappingRequest(), v1::ResumeMappingResponse())
          .ok());
  EXPECT_FALSE(orders_->Take().mapping_paused);
}

TEST_F(AgentServiceTest, AMaskIsAGreyPngOfThePicturesSize) {
  orders_->SetCamera({.width_px = 64, .height_px = 48});
  v1::SetMaskResponse response;
  const auto set = [&](const std::string& png) {
    grpc::ClientContext context;
    v1::SetMaskRequest request;
    request.set_png(png);
    response.Clear();
    return stub_->SetMask(&context, request, &response);
  };
  const auto png_of = [](const cv::Mat& picture) {
    std::vector<uchar> bytes;
    cv::imencode(".png", picture, bytes);
    return std::string(bytes.begin(), bytes.end());
  };
  cv::Mat mask(48, 64, CV_8UC1, cv::Scalar(255));
  mask.rowRange(36, 48) = cv::Scalar(0);
  const std::string good = png_of(mask);
  ASSERT_TRUE(set(good).ok());
  EXPECT_EQ(response.masked_percent(), 25);
  EXPECT_EQ(cv::countNonZero(*orders_->Take().mask), 36 * 64);
  ASSERT_TRUE(set("").ok());
  EXPECT_TRUE(orders_->Take().mask->empty());

  for (const std::string& bad :
       {std::string("no PNG"), good.substr(0, 60), png_of(mask.t()), std::string(5 << 20, 'x'),
        png_of(cv::Mat::zeros(48, 64, CV_8UC3)), png_of(cv::Mat::zeros(48, 64, CV_16UC1)),
        png_of(cv::Mat(48, 64, CV_8UC4, cv::Scalar::all(255))), png_of(mask + 12),
        png_of(cv::Mat::zeros(48, 64, CV_8UC1))}) {
    const grpc::Status status = set(bad);
    EXPECT_NE(status.error_code(), grpc::StatusCode::OK) << bad.size();
    EXPECT_FALSE(status.error_message().empty());
    EXPECT_FALSE(orders_->Take().mask.has_value());
  }
}

TEST_F(AgentServiceTest, ARateLeavesPosesOut) {
  grpc::ClientContext context;
  v1::WatchPoseRequest request;
  request.set_max_rate_hz(10);
  Track(0);
  const auto stream = stub_->WatchPose(&context, request);
  v1::WatchPoseResponse pose;
  ASSERT_TRUE(stream->Read(&pose));
  Track(50'000'000);
  Track(100'000'000);
  ASSERT_TRUE(stream->Read(&pose));
  EXPECT_EQ(pose.timestamp_ns(), 100'000'000);
  context.TryCancel();
  stream->Finish();
}

TEST_F(AgentServiceTest, AnImpossibleRateIsRefused) {
  grpc::ClientContext context;
  v1::WatchPoseRequest request;
  request.set_max_rate_hz(-1);
  const auto stream = stub_->WatchPose(&context, request);
  v1::WatchPoseResponse pose;
  EXPECT_FALSE(stream->Read(&pose));
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("max_rate_hz is -1"));
}

TEST_F(AgentServiceTest, PosesAreOfTheFrameThatIsWanted) {
  Track(1000);
  const auto first_pose = [&](v1::PosesOf poses_of) {
    grpc::ClientContext context;
    v1::WatchPoseRequest request;
    request.set_poses_of(poses_of);
    const auto stream = stub_->WatchPose(&context, request);
    v1::WatchPoseResponse pose;
    EXPECT_TRUE(stream->Read(&pose));
    context.TryCancel();
    stream->Finish();
    return pose;
  };
  const v1::WatchPoseResponse rectified = first_pose(v1::POSES_OF_RECTIFIED_CAMERA);
  EXPECT_EQ(rectified.local_from_camera().rotation_wxyz(0), 1);
  const v1::WatchPoseResponse camera = first_pose(v1::POSES_OF_UNSPECIFIED);
  EXPECT_EQ(camera.poses_of(), v1::POSES_OF_CAMERA);
  EXPECT_NEAR(camera.local_from_camera().rotation_wxyz(0), std::cos(0.1), 1e-9);
  EXPECT_EQ(camera.local_from_camera().translation(2), 2);
  const v1::WatchPoseResponse body = first_pose(v1::POSES_OF_BODY);
  EXPECT_EQ(body.poses_of(), v1::POSES_OF_BODY);
  EXPECT_NEAR(body.local_from_camera().translation(1), -1, 1e-9);

  grpc::ClientContext context;
  v1::GetAgentTrajectoryRequest request;
  request.set_poses_of(v1::POSES_OF_BODY);
  const auto stream = stub_->GetTrajectory(&context, request);
  v1::GetAgentTrajectoryResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_EQ(response.poses_of(), v1::POSES_OF_BODY);
  EXPECT_NEAR(response.poses(0).frame_from_camera().translation(1), -1, 1e-9);
  while (stream->Read(&response)) {
  }
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(AgentServiceTest, AnUnknownFrameIsRefused) {
  grpc::ClientContext context;
  v1::WatchPoseRequest request;
  request.set_poses_of(static_cast<v1::PosesOf>(7));
  const auto stream = stub_->WatchPose(&context, request);
  v1::WatchPoseResponse pose;
  EXPECT_FALSE(stream->Read(&pose));
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("poses_of is 7"));
}

TEST_F(AgentServiceTest, StreamsItsTrajectory) {
  grpc::ClientContext context;
  v1::GetAgentTrajectoryRequest request;
  request.set_from_timestamp_ns(100'000);
  const auto stream = stub_->GetTrajectory(&context, request);
  v1::GetAgentTrajectoryResponse response;
  int poses = 0;
  while (stream->Read(&response)) {
    EXPECT_LE(response.poses_size(), 1000);
    EXPECT_GE(response.poses(0).timestamp_ns(), 100'000);
    poses += response.poses_size();
  }
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(poses, 2400);
}

}  // namespace
}  // namespace corbslam::services
