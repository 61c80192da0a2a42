// Tests that an agent hears on its stream when somebody asks for exact places.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::HasSubstr;

class ExactPlacesTest : public ::testing::Test {
 protected:
  ExactPlacesTest()
      : store_(MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr),
        service_(&store_),
        server_(*Server::Start("", {&service_})),
        stub_(v1::MapStore::NewStub(server_->InProcessChannel())),
        uplink_(MakeRemoteUplink(server_->InProcessChannel())) {
    request_.mission = "m";
    request_.agent = "alpha";
  }
  ~ExactPlacesTest() override {
    uplink_->Close();
    server_->Shutdown(absl::ZeroDuration());
  }

  grpc::Status Ask(const std::string& name) {
    grpc::ClientContext context;
    v1::AskForExactPlacesRequest request;
    request.set_name(name);
    v1::AskForExactPlacesResponse response;
    return stub_->AskForExactPlaces(&context, request, &response);
  }

  MapStore store_;
  MapStoreService service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
  UplinkNotes notes_;
  std::unique_ptr<Uplink> uplink_;
  SessionRequest request_;
};

TEST_F(ExactPlacesTest, TheAgentIsAsked) {
  uplink_->Open(request_, &notes_);
  const std::optional<SessionGrant> grant = notes_.WaitForGrant();
  ASSERT_TRUE(grant.has_value());
  EXPECT_TRUE(grant->capabilities.points_follow);
  const grpc::Status status = Ask("missions/m/agents/alpha");
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_TRUE(notes_.WaitUntilExactPlacesAreWanted());
}

TEST_F(ExactPlacesTest, WhoIsNotThereIsNotAsked) {
  EXPECT_EQ(Ask("missions/m/agents/alpha").error_code(), grpc::StatusCode::NOT_FOUND);
  // Another agent is in the mission, which would go with its last session as nothing is written to
  // it.
  const std::unique_ptr<Uplink> others = MakeRemoteUplink(server_->InProcessChannel());
  UplinkNotes others_notes;
  SessionRequest others_request = request_;
  others_request.agent = "charlie";
  others->Open(others_request, &others_notes);
  ASSERT_TRUE(others_notes.WaitForGrant().has_value());
  uplink_->Open(request_, &notes_);
  ASSERT_TRUE(notes_.WaitForGrant().has_value());
  EXPECT_EQ(Ask("missions/m/agents/bravo").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Ask("missions/m").error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Ask("missions/m/agents/-").error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  uplink_->Close();
  // The store hears a little later that the session has ended.
  grpc::Status status;
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  do {
    status = Ask("missions/m/agents/alpha");
  } while (status.ok() && absl::Now() < deadline);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(status.error_message(), HasSubstr("alpha is not connected"));
  others->Close();
}

}  // namespace
}  // namespace corbslam::services
