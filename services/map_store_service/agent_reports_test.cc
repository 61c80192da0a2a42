// Tests what robots say of themselves, over a real stream in one process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "absl/time/clock.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::HasSubstr;

constexpr absl::Duration kPatience = absl::Seconds(20);

class AgentReportsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = Server::Start("", {&service_});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  std::unique_ptr<Uplink> Join(UplinkNotes& notes, uint64_t instance = 7) {
    RemoteUplinkOptions options;
    options.instance = instance;
    auto uplink = MakeRemoteUplink(server_->InProcessChannel(), options);
    SessionRequest request;
    request.mission = "m";
    request.agent = "alpha";
    uplink->Open(request, &notes);
    const auto grant = notes.WaitForGrant();
    EXPECT_TRUE(grant.has_value() && grant->capabilities.takes_reports);
    return uplink;
  }
  // Returns the only agent, once it is as wanted; else as it is in the end.
  v1::MissionAgent WaitFor(const std::function<bool(const v1::MissionAgent&)>& wanted) {
    const absl::Time end = absl::Now() + kPatience;
    while (true) {
      grpc::ClientContext context;
      v1::ListAgentsRequest request;
      request.set_parent("missions/m");
      v1::ListAgentsResponse response;
      const grpc::Status status = stub_->ListAgents(&context, request, &response);
      EXPECT_TRUE(status.ok()) << status.error_message();
      if (response.agents_size() != 1) return {};
      if (wanted(response.agents(0)) || absl::Now() > end) return response.agents(0);
      absl::SleepFor(absl::Milliseconds(5));
    }
  }

  MapStore store_{MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr};
  MapStoreService service_{&store_};
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(AgentReportsTest, TheNewestIsServedUntilAnotherProcessComes) {
  UplinkNotes notes;
  auto uplink = Join(notes);
  EXPECT_FALSE(WaitFor([](const auto&) { return true; }).has_report());
  AgentReport report{.activity = AgentActivity::kTracking, .frames = 5, .tracked = 4, .lost = 1};
  EXPECT_TRUE(uplink->SendReport(report));
  report.activity = AgentActivity::kWaiting;
  report.newest_frame_age_s = 2.5;
  EXPECT_TRUE(uplink->SendReport(report));
  const v1::MissionAgent agent = WaitFor([](const v1::MissionAgent& now) {
    return now.report().activity() == v1::AGENT_ACTIVITY_WAITING;
  });
  EXPECT_EQ(agent.report().activity(), v1::AGENT_ACTIVITY_WAITING);
  EXPECT_EQ(agent.report().tracked(), 4u);
  EXPECT_EQ(agent.report().newest_frame_age_s(), 2.5);
  EXPECT_GE(agent.report_age_s(), 0);
  EXPECT_FALSE(agent.left_on_purpose());
  uplink->Close();
  UplinkNotes next_notes;
  const auto next = Join(next_notes, 8);
  EXPECT_FALSE(WaitFor([](const auto&) { return true; }).has_report());
}

// What a robot that ends says last is heard, and that it ended by itself.
TEST_F(AgentReportsTest, ARobotThatEndsIsToldFromOneWhoseLineBroke) {
  // One that nothing is written of goes with its last robot.
  grpc::ClientContext creating;
  v1::CreateMissionRequest create;
  create.mutable_mission()->set_name("missions/m");
  v1::Mission made;
  ASSERT_TRUE(stub_->CreateMission(&creating, create, &made).ok());
  for (int i = 0; i < 20; ++i) {
    UplinkNotes notes;
    const auto uplink = Join(notes);
    EXPECT_TRUE(uplink->SendReport({.activity = AgentActivity::kFinished}));
    uplink->Close();
    const v1::MissionAgent agent =
        WaitFor([](const v1::MissionAgent& now) { return !now.connected(); });
    EXPECT_TRUE(agent.left_on_purpose());
    EXPECT_EQ(agent.report().activity(), v1::AGENT_ACTIVITY_FINISHED);
  }
  grpc::ClientContext context;
  const auto stream = stub_->Sync(&context);
  v1::SyncRequest request;
  request.mutable_open()->set_mission("missions/m");
  request.mutable_open()->set_agent("alpha");
  ASSERT_TRUE(stream->Write(request));
  v1::SyncResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_TRUE(WaitFor([](const auto& now) { return now.connected(); }).connected());
  context.TryCancel();
  stream->Finish();
  const v1::MissionAgent agent =
      WaitFor([](const v1::MissionAgent& now) { return !now.connected(); });
  EXPECT_FALSE(agent.left_on_purpose());
}

TEST_F(AgentReportsTest, AnImpossibleReportEndsTheSession) {
  UplinkNotes notes;
  const auto uplink = Join(notes);
  EXPECT_TRUE(uplink->SendReport({.newest_frame_age_s = std::numeric_limits<double>::quiet_NaN()}));
  const absl::Status reason = notes.WaitForClose();
  EXPECT_TRUE(absl::IsInvalidArgument(reason)) << reason;
  EXPECT_THAT(std::string(reason.message()), HasSubstr("report.newest_frame_age_s"));
}

}  // namespace
}  // namespace corbslam::services
