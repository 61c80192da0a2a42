// Where was this picture taken: asked over gRPC of a store whose worker is a server of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>

#include "fusion_worker/local_fusion_worker.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "services/client/remote/remote_fusion_worker.h"
#include "services/convert/features.h"
#include "services/convert/geometry.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

using map_store::InMemoryJournal;
using map_store::MapStore;
using ::testing::HasSubstr;
using testing::MakeRingMap;
using ::testing::StartsWith;
using testing::SyntheticMap;
using testing::TestAgent;

class LocalizeServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    worker_server_ = Start(worker_service_);
    remote_ = MakeRemoteFusionWorker({worker_server_->InProcessChannel()}, {});
    store_ =
        std::make_unique<MapStore>(testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                                   std::make_unique<InMemoryJournal>(), remote_.get());
    agent_ = std::make_unique<TestAgent>(*store_, "m", "a", map_);
    ASSERT_TRUE(agent_->Stream().ok());
    service_ = std::make_unique<MapStoreService>(store_.get());
    server_ = Start(*service_);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override {
    server_->Shutdown(absl::ZeroDuration());
    worker_server_->Shutdown(absl::ZeroDuration());
  }

  static std::unique_ptr<Server> Start(grpc::Service& service) {
    auto server = Server::Start("", {&service});
    EXPECT_TRUE(server.ok()) << server.status();
    return *std::move(server);
  }
  static const Keyframe& Taken(const SyntheticMap& map, int index) {
    return std::next(map.map.keyframes().begin(), index)->second;
  }
  static v1::LocalizeRequest RequestOf(const SyntheticMap& map, int index, uint64_t id = 0) {
    v1::LocalizeRequest request;
    request.set_mission("missions/m");
    ToProto(Taken(map, index).camera(), request.mutable_features()->mutable_camera());
    ToProto(Taken(map, index).payload->features, request.mutable_features()->mutable_features());
    request.set_id(id);
    return request;
  }
  grpc::Status Ask(const v1::LocalizeRequest& request, v1::LocalizeResponse* response) {
    grpc::ClientContext context;
    return stub_->Localize(&context, request, response);
  }
  void ExpectRight(const v1::LocalizeResponse& response, int index) {
    ASSERT_EQ(response.stage(), v1::LOCATE_STAGE_LOCATED) << response.DebugString();
    const auto found = FromProto(response.camera_from_island());
    ASSERT_TRUE(found.ok());
    const Rigid3d truth = std::next(near_.true_camera_from_world.begin(), index)->second *
                          map_.true_camera_from_world.begin()->second.Inverse();
    const Rigid3d error = *found * truth.Inverse();
    EXPECT_LT(error.translation.norm(), 0.1);
    EXPECT_EQ(response.covariance_size(), 36);
    EXPECT_EQ(response.island(), "missions/m/localMaps/000000000000000a");
    EXPECT_TRUE(response.in_global_frame());
    ASSERT_GT(response.keyframes_size(), 0);
    EXPECT_THAT(response.keyframes(0),
                StartsWith("missions/m/localMaps/000000000000000a/keyframes/"));
  }

  const SyntheticMap map_ = MakeRingMap(0xa, 0, 14, 0);
  const SyntheticMap near_ = MakeRingMap(0xc, 14, 8, 0);
  const SyntheticMap nowhere_ = MakeRingMap(0xe, 200, 4, 0);
  std::unique_ptr<FusionWorker> worker_ = fusion_worker::MakeLocalFusionWorker();
  FusionWorkerService worker_service_{worker_.get()};
  std::unique_ptr<Server> worker_server_;
  std::unique_ptr<FusionWorker> remote_;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<TestAgent> agent_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(LocalizeServiceTest, FindsFeaturesPlace) {
  v1::LocalizeResponse response;
  const grpc::Status status = Ask(RequestOf(near_, 3, 17), &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.id(), 17u);
  ExpectRight(response, 3);
}

TEST_F(LocalizeServiceTest, NotToFindAPlaceIsAnAnswer) {
  v1::LocalizeResponse response;
  ASSERT_TRUE(Ask(RequestOf(nowhere_, 1), &response).ok());
  EXPECT_NE(response.stage(), v1::LOCATE_STAGE_UNSPECIFIED);
  EXPECT_NE(response.stage(), v1::LOCATE_STAGE_LOCATED);
  EXPECT_FALSE(response.has_camera_from_island());
  EXPECT_EQ(response.keyframes_size(), 0);
}

TEST_F(LocalizeServiceTest, AStreamAnswersEachInItsOrder) {
  grpc::ClientContext context;
  const auto stream = stub_->LocalizeStream(&context);
  // In one process a message is taken only when the other side reads it.
  std::thread writer([&] {
    for (int i = 1; i <= 4; ++i) {
      stream->Write(RequestOf(i == 2 ? nowhere_ : near_, i % 4, static_cast<uint64_t>(i)));
    }
    stream->WritesDone();
  });
  v1::LocalizeResponse response;
  for (uint64_t i = 1; i <= 4; ++i) {
    ASSERT_TRUE(stream->Read(&response));
    EXPECT_EQ(response.id(), i);
    EXPECT_EQ(response.stage() == v1::LOCATE_STAGE_LOCATED, i != 2);
  }
  writer.join();
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(LocalizeServiceTest, AWrongRequestEndsAStreamAfterItsAnswers) {
  grpc::ClientContext context;
  const auto stream = stub_->LocalizeStream(&context);
  ASSERT_TRUE(stream->Write(RequestOf(near_, 3, 1)));
  v1::LocalizeResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_EQ(response.id(), 1u);
  stream->Write(v1::LocalizeRequest());
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(LocalizeServiceTest, NamesWhatIsWrong) {
  const auto expect = [&](const v1::LocalizeRequest& request, grpc::StatusCode code,
                          const std::string& says) {
    v1::LocalizeResponse response;
    const grpc::Status status = Ask(request, &response);
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(says));
  };
  v1::LocalizeRequest request = RequestOf(near_, 3);
  request.set_mission("missions/other");
  expect(request, grpc::StatusCode::NOT_FOUND, "other");
  request.set_mission("m");
  expect(request, grpc::StatusCode::INVALID_ARGUMENT, "missions/");
  request = RequestOf(near_, 3);
  request.clear_features();
  expect(request, grpc::StatusCode::INVALID_ARGUMENT, "neither a picture nor features");
  request.mutable_picture()->set_encoded("no picture");
  expect(request, grpc::StatusCode::INVALID_ARGUMENT, "picture.camera");
  ToProto(AsRecorded(Taken(near_, 3).camera()), request.mutable_picture()->mutable_camera());
  request.mutable_picture()->mutable_camera()->clear_camera_from_recorded();
  expect(request, grpc::StatusCode::INVALID_ARGUMENT, "neither a PNG nor a JPEG");
  request = RequestOf(near_, 3);
  request.mutable_prior()->set_radius_m(5);
  expect(request, grpc::StatusCode::INVALID_ARGUMENT, "prior.camera_from_global");
  ToProto(Rigid3d(), request.mutable_prior()->mutable_camera_from_global());
  request.mutable_prior()->set_radius_m(-1);
  expect(request, grpc::StatusCode::INVALID_ARGUMENT, "prior.radius_m is -1");
}

TEST_F(LocalizeServiceTest, APriorIsInTheGlobalFrame) {
  v1::LocalizeRequest request = RequestOf(near_, 3);
  v1::LocalizeResponse response;
  ASSERT_TRUE(Ask(request, &response).ok());
  *request.mutable_prior()->mutable_camera_from_global() = response.camera_from_island();
  request.mutable_prior()->set_radius_m(3);
  ASSERT_TRUE(Ask(request, &response).ok());
  ExpectRight(response, 3);
  request.mutable_prior()->mutable_camera_from_global()->set_translation(0, 500);
  ASSERT_TRUE(Ask(request, &response).ok());
  EXPECT_EQ(response.stage(), v1::LOCATE_STAGE_NO_CANDIDATES);
}

TEST_F(LocalizeServiceTest, WithoutAWorkerItSaysSo) {
  const auto nobody = MakeRemoteFusionWorker({}, {});
  MapStore store(testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                 std::make_unique<InMemoryJournal>(), nobody.get());
  TestAgent agent(store, "m", "a", map_);
  ASSERT_TRUE(agent.Stream().ok());
  MapStoreService service(&store);
  const auto server = Start(service);
  const auto stub = v1::MapStore::NewStub(server->InProcessChannel());
  grpc::ClientContext context;
  v1::LocalizeResponse response;
  EXPECT_EQ(stub->Localize(&context, RequestOf(near_, 3), &response).error_code(),
            grpc::StatusCode::UNAVAILABLE);
  server->Shutdown(absl::ZeroDuration());
}

}  // namespace
}  // namespace corbslam::services
