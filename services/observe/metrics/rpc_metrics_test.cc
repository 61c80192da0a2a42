#include "services/observe/metrics/rpc_metrics.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <memory>

#include "absl/time/clock.h"
#include "map_store/testing/shared_world.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/metrics/testing/metric_values.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;

namespace {

using testing::SumOf;
using testing::ValueOf;

constexpr char kSync[] = "corbslam.v1.MapStore/Sync";
constexpr char kWatch[] = "corbslam.v1.MapStore/WatchMap";
constexpr char kGet[] = "corbslam.v1.MapStore/GetMission";
constexpr char kList[] = "corbslam.v1.MapStore/ListMissions";

// Runs a store's service in this process and asks it through a stub.
class RpcMetricsTest : public ::testing::Test {
 protected:
  RpcMetricsTest() {
    ServerOptions options;
    options.rpc_observer = &metrics_;
    server_ = *Server::Start("127.0.0.1:0", {&service_}, options);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }

  // Returns the count of calls that ended. They are counted before their caller knows, but for
  // cancelled ones.
  double Calls(const std::string& method, const std::string& code) {
    return ValueOf(registry_.Collect(), "corbslam_rpc_calls_total",
                   {{"method", method}, {"code", code}})
        .value_or(0);
  }
  double Bytes(const std::string& name, const std::string& method) {
    return SumOf(registry_.Collect(), name, {{"method", method}}).value_or(0);
  }
  double Running(const std::string& method) {
    return ValueOf(registry_.Collect(), "corbslam_rpc_calls_running", {{"method", method}})
        .value_or(-1);
  }

  prometheus::Registry registry_;
  RpcMetrics metrics_{registry_};
  MapStore store_{testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                  std::make_unique<InMemoryJournal>(), nullptr};
  MapStoreService service_{&store_};
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(RpcMetricsTest, CallsAreCountedByHowTheyEndAndMeasured) {
  v1::ListMissionsRequest list;
  list.set_page_size(12345);
  for (int i = 0; i < 3; ++i) {
    grpc::ClientContext context;
    v1::ListMissionsResponse response;
    ASSERT_TRUE(stub_->ListMissions(&context, list, &response).ok());
  }
  grpc::ClientContext context;
  v1::GetMissionRequest get;
  get.set_name("missions/nowhere");
  v1::Mission mission;
  EXPECT_EQ(stub_->GetMission(&context, get, &mission).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Calls(kList, "OK"), 3);
  EXPECT_EQ(Calls(kGet, "NOT_FOUND"), 1);
  EXPECT_EQ(Calls(kGet, "OK"), 0);
  EXPECT_EQ(Running(kList), 0);
  EXPECT_EQ(Bytes("corbslam_rpc_received_message_bytes", kList),
            3 * static_cast<double>(list.ByteSizeLong()));
  EXPECT_EQ(ValueOf(registry_.Collect(), "corbslam_rpc_duration_seconds", {{"method", kList}}), 3);
}

TEST_F(RpcMetricsTest, TheRawStreamIsMeasuredToo) {
  grpc::ClientContext context;
  const auto stream = stub_->Sync(&context);
  v1::SyncRequest open;
  open.mutable_open()->set_mission("missions/lab");
  open.mutable_open()->set_agent("alpha");
  ASSERT_TRUE(stream->Write(open));
  v1::SyncResponse grant;
  ASSERT_TRUE(stream->Read(&grant));
  EXPECT_EQ(Running(kSync), 1);
  EXPECT_EQ(Bytes("corbslam_rpc_received_message_bytes", kSync),
            static_cast<double>(open.ByteSizeLong()));
  EXPECT_EQ(Bytes("corbslam_rpc_sent_message_bytes", kSync),
            static_cast<double>(grant.ByteSizeLong()));
  ASSERT_TRUE(stream->WritesDone());
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(Calls(kSync, "OK"), 1);
  EXPECT_EQ(Running(kSync), 0);
}

TEST_F(RpcMetricsTest, ACallThatItsCallerGaveUpIsCancelled) {
  ASSERT_TRUE(store_.OpenSession({"lab", "alpha", 0, {}}).ok());
  grpc::ClientContext context;
  v1::WatchMapRequest request;
  request.set_mission("missions/lab");
  const auto stream = stub_->WatchMap(&context, request);
  v1::WatchMapResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_EQ(Running(kWatch), 1);
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (Running(kWatch) != 0 && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(5));
  EXPECT_EQ(Running(kWatch), 0);
  EXPECT_EQ(Calls(kWatch, "CANCELLED"), 1);
}

}  // namespace
}  // namespace corbslam::services
