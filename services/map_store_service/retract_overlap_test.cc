// Tests that a person finds overlaps and takes them back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "map_store/testing/byte_journal.h"
#include "map_store/testing/small_mission.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class RetractOverlapTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto bytes = std::make_shared<testing::JournalBytes>();
    testing::ByteJournal journal(bytes);
    for (const auto& record : testing::MakeSmallMission()) {
      ASSERT_TRUE(journal.Append("m", record).ok());
    }
    store_ = std::make_unique<MapStore>(MapStoreOptions(), nullptr,
                                        std::make_unique<testing::ByteJournal>(bytes), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  v1::ListOverlapsResponse ListAccepted() {
    grpc::ClientContext context;
    v1::ListOverlapsRequest request;
    request.set_parent("missions/m");
    request.set_accepted_only(true);
    v1::ListOverlapsResponse response;
    EXPECT_TRUE(stub_->ListOverlaps(&context, request, &response).ok());
    return response;
  }
  grpc::Status Retract(const std::string& name, v1::RetractOverlapResponse* response) {
    grpc::ClientContext context;
    v1::RetractOverlapRequest request;
    request.set_name(name);
    return stub_->RetractOverlap(&context, request, response);
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(RetractOverlapTest, ByTheNameThatTheListGives) {
  const v1::ListOverlapsResponse accepted = ListAccepted();
  ASSERT_EQ(accepted.overlaps_size(), 1);
  const std::string name = accepted.overlaps(0).name();
  v1::RetractOverlapResponse response;
  const grpc::Status status = Retract(name, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_THAT(response.overlaps(), ElementsAre(name));
  // Another overlap, which was refused because it contradicted this one, may be accepted now.
  const v1::ListOverlapsResponse left = ListAccepted();
  for (const v1::Overlap& other : left.overlaps()) EXPECT_NE(other.name(), name);
  EXPECT_EQ(store_->GetMission("m")->islands, 2u);

  const grpc::Status again = Retract(name, &response);
  EXPECT_EQ(again.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(again.error_message(), HasSubstr("TAKEN_BACK"));
}

TEST_F(RetractOverlapTest, ListedIsHowCertainItIs) {
  const v1::ListOverlapsResponse accepted = ListAccepted();
  ASSERT_EQ(accepted.overlaps_size(), 1);
  EXPECT_DOUBLE_EQ(accepted.overlaps(0).translation_sigma(), 0.02);
  EXPECT_DOUBLE_EQ(accepted.overlaps(0).rotation_sigma_rad(), 0.002);
  EXPECT_EQ(accepted.overlaps(0).log_scale_sigma(), 0);
}

TEST_F(RetractOverlapTest, DerivingAgainForgetsTheRest) {
  ASSERT_GT(store_->GetStatistics("m")->revision, 0u);
  const uint64_t revision = store_->GetStatistics("m")->revision;
  grpc::ClientContext context;
  v1::RederiveGlobalLayerRequest request;
  request.set_name("missions/m");
  v1::RederiveGlobalLayerResponse response;
  const grpc::Status status = stub_->RederiveGlobalLayer(&context, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(store_->GetStatistics("m")->revision, revision + 1);
  EXPECT_EQ(ListAccepted().overlaps_size(), 0);
  grpc::ClientContext unknown;
  request.set_name("missions/nobodys");
  EXPECT_EQ(stub_->RederiveGlobalLayer(&unknown, request, &response).error_code(),
            grpc::StatusCode::NOT_FOUND);
}

TEST_F(RetractOverlapTest, OthersAreRefusedByName) {
  v1::RetractOverlapResponse response;
  EXPECT_EQ(Retract("missions/m/overlaps/77", &response).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Retract("missions/n/overlaps/1", &response).error_code(), grpc::StatusCode::NOT_FOUND);
  for (const std::string bad : {"missions/m", "missions/m/overlaps/x", "missions/m/overlaps/-1"}) {
    const grpc::Status status = Retract(bad, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << bad;
    EXPECT_THAT(status.error_message(), HasSubstr("missions/{mission}/overlaps/{number}"));
  }
}

}  // namespace
}  // namespace corbslam::services
