#include "services/map_store_service/streams/stream_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "services/convert/localised_frames.h"
#include "services/convert/map_update.h"
#include "services/convert/shared_update.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::HasSubstr;

TEST(HostOfTest, LeavesThePortOut) {
  EXPECT_EQ(HostOfPeer("ipv4:10.0.0.7:4711"), "ipv4:10.0.0.7");
  EXPECT_EQ(HostOfPeer("ipv6:%5B::1%5D:4711"), "ipv6:%5B::1%5D");
  EXPECT_EQ(HostOfPeer("unix:/tmp/socket:1"), "unix:/tmp/socket:1");
}

void ExpectTooMuch(const absl::Status& status, const std::string& says) {
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(says));
}

TEST(StreamLimitsTest, CountsWhatIsOpen) {
  StreamLimits limits({.max_streams = 3, .max_streams_per_host = 2, .max_streams_per_agent = 1});
  auto first = limits.Enter("ipv4:1.1.1.1:1");
  auto second = limits.Enter("ipv4:1.1.1.1:2");
  ExpectTooMuch(limits.Enter("ipv4:1.1.1.1:3").status(), "ipv4:1.1.1.1 has 2 open streams");
  auto third = limits.Enter("ipv4:2.2.2.2:1");
  ExpectTooMuch(limits.Enter("ipv4:3.3.3.3:1").status(), "the limit is 3");
  EXPECT_TRUE((*first)->Name("missions/m/agents/a").ok());
  ExpectTooMuch((*second)->Name("missions/m/agents/a"), "missions/m/agents/a has 1");
  first->reset();
  EXPECT_TRUE((*second)->Name("missions/m/agents/a").ok());
  EXPECT_TRUE(limits.Enter("ipv4:1.1.1.1:4").ok());
  EXPECT_EQ(limits.open_streams(), 2u);
}

TEST(StreamLimitsTest, BoundsUnfinishedBatches) {
  StreamLimits limits({.max_batch_bytes = 100, .max_unfinished_bytes = 150});
  const auto first = *limits.Enter("a");
  auto second = *limits.Enter("b");
  EXPECT_TRUE(first->Hold(60).ok());
  ExpectTooMuch(first->Hold(41), "101 bytes; the limit is 100");
  EXPECT_TRUE(second->Hold(90).ok());
  ExpectTooMuch(first->Hold(1), "the limit of 150");
  second.reset();
  EXPECT_TRUE(first->Hold(40).ok());
  first->ReleaseAll();
  EXPECT_EQ(limits.unfinished_bytes(), 0u);
}

TEST(StreamLimitOptionsTest, NameTheFieldThatIsOutOfRange) {
  EXPECT_TRUE(StreamLimitOptions().Validate().ok());
  const std::vector<std::pair<std::string, std::function<void(StreamLimitOptions&)>>> cases = {
      {"max_streams is 0", [](auto& o) { o.max_streams = 0; }},
      {"max_streams_per_host is 0", [](auto& o) { o.max_streams_per_host = 0; }},
      {"max_streams_per_agent is 1", [](auto& o) { o.max_streams_per_agent = 1; }},
      {"max_message_bytes is 100", [](auto& o) { o.max_message_bytes = 100; }},
      {"max_message_bytes", [](auto& o) { o.max_message_bytes = 5u << 20; }},
      {"max_batch_bytes", [](auto& o) { o.max_batch_bytes = 1u << 30; }},
      {"max_unfinished_bytes is 0", [](auto& o) { o.max_unfinished_bytes = 0; }},
      {"open_timeout_s is 0", [](auto& o) { o.open_timeout_s = 0; }},
      {"part_timeout_s is -1", [](auto& o) { o.part_timeout_s = -1; }},
      {"max_waiting_calls is 0", [](auto& o) { o.max_waiting_calls = 0; }}};
  for (const auto& [says, break_it] : cases) {
    StreamLimitOptions options;
    break_it(options);
    const absl::Status status = options.Validate();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << says;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
  }
}

// Opens streams through the real stub, in one process.
class LimitedStreamsTest : public ::testing::Test {
 protected:
  using Stream = grpc::ClientReaderWriter<v1::SyncRequest, v1::SyncResponse>;

  void Start(const StreamLimitOptions& limits) {
    store_ = std::make_unique<MapStore>(MapStoreOptions(), nullptr,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    MapStoreServiceOptions options;
    options.streams = limits;
    service_ = std::make_unique<MapStoreService>(store_.get(), options);
    server_ = *Server::Start("", {service_.get()});
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  std::unique_ptr<Stream> Open(const std::string& agent, bool localise_only = false) {
    contexts_.push_back(std::make_unique<grpc::ClientContext>());
    auto stream = stub_->Sync(contexts_.back().get());
    v1::SyncRequest open;
    SessionRequest session;
    session.mission = "m";
    session.agent = agent;
    session.localise_only = localise_only;
    ToProto(session, open.mutable_open());
    stream->Write(open);
    return stream;
  }
  static bool IsGranted(Stream& stream) {
    v1::SyncResponse response;
    return stream.Read(&response) && response.has_grant();
  }
  static void ExpectEnd(Stream& stream, grpc::StatusCode code, const std::string& says) {
    v1::SyncResponse response;
    while (stream.Read(&response)) EXPECT_FALSE(response.has_acknowledgement());
    const grpc::Status status = stream.Finish();
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(says));
  }
  template <typename Response, typename Open>
  static void ExpectRefusedReading(Open open) {
    grpc::ClientContext context;
    const auto stream = open(&context);
    Response response;
    EXPECT_FALSE(stream->Read(&response));
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  }
  static std::vector<v1::SyncRequest> Parts(int keyframes) {
    std::mt19937 random(1);
    CameraBook sent;
    std::vector<v1::SyncRequest> requests;
    for (auto& part :
         ToProto(test_data::MakeBatch(random, test_data::kMap, 1, keyframes, 2000), sent, 100000)) {
      *requests.emplace_back().mutable_batch() = std::move(part);
    }
    return requests;
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts_;
};

TEST_F(LimitedStreamsTest, TooManyStreamsAreRefusedAndTheOthersGoOn) {
  Start({.max_streams = 2});
  const auto first = Open("a");
  EXPECT_TRUE(IsGranted(*first));
  const auto second = Open("b");
  EXPECT_TRUE(IsGranted(*second));
  ExpectEnd(*Open("c"), grpc::StatusCode::RESOURCE_EXHAUSTED, "the limit is 2");
  ExpectRefusedReading<v1::WatchMapResponse>(
      [this](auto* context) { return stub_->WatchMap(context, v1::WatchMapRequest()); });
  ExpectRefusedReading<v1::MissionEvent>(
      [this](auto* context) { return stub_->WatchEvents(context, v1::WatchEventsRequest()); });
  v1::ReplayMapRequest replay;
  replay.set_mission("missions/m");
  ExpectRefusedReading<v1::WatchMapResponse>(
      [this, &replay](auto* context) { return stub_->ReplayMap(context, replay); });
  ExpectRefusedReading<v1::GetTrajectoryResponse>(
      [this](auto* context) { return stub_->GetTrajectory(context, v1::GetTrajectoryRequest()); });
  ExpectRefusedReading<v1::BackupMissionResponse>(
      [this](auto* context) { return stub_->BackupMission(context, v1::BackupMissionRequest()); });
  grpc::ClientContext context;
  v1::Mission mission;
  EXPECT_EQ(stub_->RestoreMission(&context, &mission)->Finish().error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  for (const v1::SyncRequest& part : Parts(1)) EXPECT_TRUE(first->Write(part));
  v1::SyncResponse response;
  EXPECT_TRUE(first->Read(&response));
  EXPECT_TRUE(response.has_acknowledgement());
  second->WritesDone();
  EXPECT_TRUE(second->Finish().ok());
  // There is room again, as one stream has gone.
  EXPECT_TRUE(IsGranted(*Open("c")));
  contexts_.back()->TryCancel();
  contexts_.front()->TryCancel();
}

TEST_F(LimitedStreamsTest, AStreamThatSaysNothingEnds) {
  Start({.open_timeout_s = 0.1});
  grpc::ClientContext context;
  const auto stream = stub_->Sync(&context);
  ExpectEnd(*stream, grpc::StatusCode::DEADLINE_EXCEEDED, "the first message did not come");
}

TEST_F(LimitedStreamsTest, ABackupThatDoesNotGoOnEndsItsStream) {
  Start({.part_timeout_s = 0.2});
  v1::Mission mission;
  grpc::ClientContext context;
  const auto begun = stub_->RestoreMission(&context, &mission);
  v1::RestoreMissionRequest first;
  first.set_name("missions/m");
  EXPECT_TRUE(begun->Write(first));
  const grpc::Status status = begun->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_THAT(status.error_message(), HasSubstr("the next piece did not come within 0.2 s"));
  EXPECT_EQ(service_->streams().open_streams(), 0u);
}

TEST_F(LimitedStreamsTest, ABackupThatNeverBeginsEndsItsStream) {
  Start({.open_timeout_s = 0.1});
  v1::Mission mission;
  grpc::ClientContext context;
  EXPECT_EQ(stub_->RestoreMission(&context, &mission)->Finish().error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(LimitedStreamsTest, AnOpenStreamMayBeSilent) {
  Start({.open_timeout_s = 0.1, .part_timeout_s = 0.1});
  const auto stream = Open("a");
  EXPECT_TRUE(IsGranted(*stream));
  absl::SleepFor(absl::Milliseconds(400));
  for (const v1::SyncRequest& part : Parts(1)) EXPECT_TRUE(stream->Write(part));
  v1::SyncResponse response;
  EXPECT_TRUE(stream->Read(&response));
  EXPECT_TRUE(response.has_acknowledgement());
  contexts_.back()->TryCancel();
  stream->Finish();
}

TEST_F(LimitedStreamsTest, ABatchThatIsNeverFinishedEndsItsStream) {
  Start({.part_timeout_s = 0.1});
  const auto stream = Open("a");
  EXPECT_TRUE(IsGranted(*stream));
  EXPECT_TRUE(stream->Write(Parts(3).front()));
  ExpectEnd(*stream, grpc::StatusCode::DEADLINE_EXCEEDED, "the next part of batch 1");
}

TEST_F(LimitedStreamsTest, ABatchThatIsTooLongEndsItsStream) {
  Start({.max_batch_bytes = 150000});
  const auto stream = Open("a");
  EXPECT_TRUE(IsGranted(*stream));
  for (const v1::SyncRequest& part : Parts(5)) {
    if (!stream->Write(part)) break;
  }
  ExpectEnd(*stream, grpc::StatusCode::RESOURCE_EXHAUSTED, "the limit is 150000");
}

TEST_F(LimitedStreamsTest, AMessageThatIsTooLongEndsItsStream) {
  Start({.max_message_bytes = 50000});
  const auto stream = Open("a");
  EXPECT_TRUE(IsGranted(*stream));
  EXPECT_TRUE(stream->Write(Parts(1).front()));
  ExpectEnd(*stream, grpc::StatusCode::RESOURCE_EXHAUSTED, "the limit is 50000");
}

TEST_F(LimitedStreamsTest, WhatAnAgentLocalisesCountsWhileTheStoreWorksOnIt) {
  Start({.max_batch_bytes = 20000, .max_unfinished_bytes = 20000});
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  const auto stream = Open("guest", /*localise_only=*/true);
  EXPECT_TRUE(IsGranted(*stream));
  LocalisedFrames part;
  part.run = 7;
  const auto send = [&](int frames) {
    ++part.number;
    part.tracked_frames.assign(frames, {1, {{1}, 0}, Rigid3d::Identity()});
    v1::SyncRequest request;
    ToProto(part, request.mutable_localised());
    EXPECT_TRUE(stream->Write(request));
  };
  // Together they are over the limit.
  for (int i = 1; i <= 3; ++i) {
    send(100);
    v1::SyncResponse response;
    EXPECT_TRUE(stream->Read(&response));
    EXPECT_EQ(response.localised_kept().number(), static_cast<uint64_t>(i));
  }
  EXPECT_EQ(service_->streams().unfinished_bytes(), 0u);
  send(300);
  ExpectEnd(*stream, grpc::StatusCode::RESOURCE_EXHAUSTED, "the limit is 20000");
}

}  // namespace
}  // namespace corbslam::services
