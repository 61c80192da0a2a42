// Tests that an operator deletes a robot's old sessions, and only these.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>

#include "map_store/testing/one_robots_store.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kKeyframesOfDrive;

constexpr char kRobot[] = "missions/m/agents/r";

v1::ForgetLocalMapsRequest AllBut(uint32_t keep, const std::string& parent = kRobot) {
  v1::ForgetLocalMapsRequest request;
  request.set_parent(parent);
  request.set_keep(keep);
  return request;
}

class ForgetLocalMapsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    service_ = std::make_unique<MapStoreService>(&robot_.store());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  grpc::Status Forget(const v1::ForgetLocalMapsRequest& request) {
    grpc::ClientContext context;
    return stub_->ForgetLocalMaps(&context, request, &forgotten_);
  }
  void ExpectRefused(const v1::ForgetLocalMapsRequest& request, grpc::StatusCode code,
                     const std::string& reason) {
    const grpc::Status status = Forget(request);
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(reason));
    EXPECT_EQ(robot_.store().GetMission("m")->keyframes, keyframes_);
  }
  grpc::Status GetLocalMap(const std::string& id) {
    grpc::ClientContext context;
    v1::GetLocalMapRequest request;
    request.set_name("missions/m/localMaps/" + id);
    v1::LocalMap found;
    return stub_->GetLocalMap(&context, request, &found);
  }
  // Makes one local map of the first three sessions.
  void StartAll() {
    robot_.StartAll();
    keyframes_ = 4 * kKeyframesOfDrive;
  }

  testing::OneRobotsStore robot_{true};
  size_t keyframes_ = 0;
  v1::ForgetLocalMapsResponse forgotten_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(ForgetLocalMapsTest, DeletesAllButTheNewestAndSaysWhatThatWas) {
  StartAll();
  ASSERT_TRUE(Forget(AllBut(1)).ok());
  EXPECT_THAT(forgotten_.local_maps(), ElementsAre("0000000000000001"));
  EXPECT_EQ(forgotten_.parts(), 2u);
  EXPECT_EQ(forgotten_.keyframes(), 3 * kKeyframesOfDrive);
  EXPECT_GT(forgotten_.map_points(), 0u);
  EXPECT_GT(forgotten_.stored_bytes(), 0u);
  for (const char* gone : {"0000000000000001", "0000000000000003"}) {
    EXPECT_EQ(GetLocalMap(gone).error_code(), grpc::StatusCode::NOT_FOUND) << gone;
  }
  EXPECT_TRUE(GetLocalMap("0000000000000004").ok());
  ASSERT_TRUE(Forget(AllBut(1)).ok()) << "again is no error";
  EXPECT_EQ(forgotten_.local_maps_size(), 0);
}

TEST_F(ForgetLocalMapsTest, AQuestionDeletesNothing) {
  StartAll();
  v1::ForgetLocalMapsRequest request = AllBut(0);
  request.set_dry_run(true);
  ASSERT_TRUE(Forget(request).ok());
  EXPECT_THAT(forgotten_.local_maps(), ElementsAre("0000000000000001", "0000000000000004"));
  EXPECT_EQ(robot_.store().GetMission("m")->keyframes, keyframes_);
}

// The times are the robot's own; its last session is the newest.
TEST_F(ForgetLocalMapsTest, DeletesWhatEndedBeforeATime) {
  StartAll();
  v1::ForgetLocalMapsRequest request;
  request.set_parent(kRobot);
  request.set_before_ns(0);
  ASSERT_TRUE(Forget(request).ok());
  EXPECT_EQ(forgotten_.local_maps_size(), 0) << "none is as old";
  request.set_before_ns(std::numeric_limits<int64_t>::max());
  ASSERT_TRUE(Forget(request).ok());
  EXPECT_EQ(forgotten_.local_maps_size(), 2);
  EXPECT_EQ(robot_.store().GetMission("m")->local_maps, 0u);
}

TEST_F(ForgetLocalMapsTest, RefusesWhatItDoesNotKnow) {
  StartAll();
  using grpc::StatusCode;
  ExpectRefused(AllBut(1, "missions/m/agents/nobody"), StatusCode::NOT_FOUND,
                "mission m has no agent nobody");
  ExpectRefused(AllBut(1, "missions/other/agents/r"), StatusCode::NOT_FOUND, "other");
  ExpectRefused(AllBut(1, "missions/m"), StatusCode::INVALID_ARGUMENT, "missions/m");
  ExpectRefused(AllBut(1, "missions/m/agents/-"), StatusCode::INVALID_ARGUMENT, "-");
  ExpectRefused(AllBut(1, "missions/m/localMaps/0000000000000001"), StatusCode::INVALID_ARGUMENT,
                "localMaps");
  ExpectRefused(AllBut(1, ""), StatusCode::INVALID_ARGUMENT, "agents");
  v1::ForgetLocalMapsRequest neither = AllBut(1);
  neither.clear_keep();
  ExpectRefused(neither, StatusCode::INVALID_ARGUMENT, "before which time, or how many");
}

TEST_F(ForgetLocalMapsTest, RefusesWhileFusionIsBusyAndSaysSo) {
  robot_.Drive(0);
  robot_.Drive(1);
  keyframes_ = 2 * kKeyframesOfDrive;
  ExpectRefused(AllBut(0), grpc::StatusCode::FAILED_PRECONDITION, "mission m is being fused");
  ASSERT_TRUE(robot_.store().RunFusionUntilIdle("m").ok());
  EXPECT_TRUE(Forget(AllBut(0)).ok());
}

// An open session is the robot's own.
TEST_F(ForgetLocalMapsTest, WhatIsOpenStays) {
  robot_.Start(0);
  testing::TestAgent open(robot_.store(), "m", testing::kOneRobot, robot_.drives()[1]);
  ASSERT_TRUE(open.Stream(3).ok());
  ASSERT_TRUE(robot_.store().RunFusionUntilIdle("m").ok());
  ASSERT_TRUE(Forget(AllBut(0)).ok());
  EXPECT_THAT(forgotten_.local_maps(), ElementsAre("0000000000000001"));
  EXPECT_TRUE(open.Stream(2).ok()) << "it goes on";
}

}  // namespace
}  // namespace corbslam::services
