// Tests the map store behind its contract, through the real stubs in one process.
#include "services/map_store_service/map_store_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/limits.h"
#include "services/convert/map_update.h"
#include "services/convert/shared_update.h"
#include "services/convert/testing/test_data.h"
#include "services/programs/default_vocabulary.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using test_data::kMap;
using test_data::kOtherMap;
using test_data::MakeBatch;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

using Listener = UplinkNotes;

class MapStoreServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    store_ = std::make_unique<MapStore>(MapStoreOptions(), *vocabulary,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    channel_ = server_->InProcessChannel();
    stub_ = v1::MapStore::NewStub(channel_);
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  static SessionRequest Session(const std::string& agent, std::vector<LocalMapId> maps = {}) {
    return {.mission = "m", .agent = agent, .last_revision = 0, .local_maps = std::move(maps)};
  }
  // Stores `count` batches of a local map over a session of its own.
  void Upload(const std::string& agent, LocalMapId local_map, int count) {
    std::mt19937 random(7);
    const auto uplink = MakeRemoteUplink(channel_);
    Listener listener;
    uplink->Open(Session(agent), &listener);
    ASSERT_TRUE(listener.WaitForGrant().has_value());
    for (int i = 1; i <= count; ++i) {
      ASSERT_TRUE(uplink->Send(MakeBatch(random, local_map, static_cast<uint64_t>(i))));
    }
    ASSERT_EQ(listener.WaitForAcknowledgements(static_cast<size_t>(count)),
              static_cast<uint64_t>(count));
    uplink->Close();
  }
  uint64_t CountKeyframes() {
    grpc::ClientContext context;
    v1::GetMissionRequest request;
    request.set_name("missions/m");
    v1::Mission mission;
    return stub_->GetMission(&context, request, &mission).ok() ? mission.keyframes() : 0;
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(MapStoreServiceTest, ASessionResumesWhereItWasAcknowledged) {
  Upload("alpha", kMap, 3);
  EXPECT_EQ(CountKeyframes(), 6u);

  std::mt19937 random(7);
  std::vector<MapUpdateBatch> batches;
  for (uint64_t i = 1; i <= 4; ++i) batches.push_back(MakeBatch(random, kMap, i));
  const auto uplink = MakeRemoteUplink(channel_);
  Listener listener;
  uplink->Open(Session("alpha", {kMap}), &listener);
  const auto grant = listener.WaitForGrant();
  ASSERT_TRUE(grant.has_value());
  ASSERT_EQ(grant->acknowledged.size(), 1u);
  EXPECT_EQ(grant->acknowledged[0].local_map, kMap);
  EXPECT_EQ(grant->acknowledged[0].number, 3u);
  // The first batch is one that the store has; the second is new, and an earlier stream named its
  // camera.
  ASSERT_TRUE(uplink->Send(batches[2]));
  ASSERT_TRUE(uplink->Send(batches[3]));
  EXPECT_EQ(listener.WaitForAcknowledgements(2), 4u);
  EXPECT_EQ(CountKeyframes(), 8u);
  EXPECT_GT(uplink->bytes_up(), 5000u);
  EXPECT_GT(uplink->bytes_down(), 10u);
  uplink->Close();
  EXPECT_FALSE(listener.IsClosed());
  EXPECT_FALSE(uplink->Send(batches[3]));
}

TEST_F(MapStoreServiceTest, ASecondSessionOfAnAgentFencesTheFirst) {
  const auto first = MakeRemoteUplink(channel_);
  Listener first_listener;
  first->Open(Session("alpha"), &first_listener);
  ASSERT_TRUE(first_listener.WaitForGrant().has_value());
  const auto second = MakeRemoteUplink(channel_);
  Listener second_listener;
  second->Open(Session("alpha"), &second_listener);
  ASSERT_TRUE(second_listener.WaitForGrant().has_value());
  // The first session hears of its end though it sends nothing.
  const absl::Status reason = first_listener.WaitForClose();
  ASSERT_TRUE(first_listener.IsClosed());
  EXPECT_EQ(reason.code(), absl::StatusCode::kAborted) << reason;
  EXPECT_FALSE(second_listener.IsClosed());
}

// Makes an uplink as another process of this name would.
std::unique_ptr<Uplink> MakeOthersUplink(std::shared_ptr<grpc::Channel> channel, bool take_over) {
  RemoteUplinkOptions options;
  options.instance = ProcessInstance() + 1;
  options.take_over = take_over;
  return MakeRemoteUplink(std::move(channel), options);
}

TEST_F(MapStoreServiceTest, ASecondProcessOfAnAgentIsToldSoAndTheFirstGoesOn) {
  const auto first = MakeRemoteUplink(channel_);
  Listener first_listener;
  first->Open(Session("alpha"), &first_listener);
  ASSERT_TRUE(first_listener.WaitForGrant().has_value());
  const auto second = MakeOthersUplink(channel_, /*take_over=*/false);
  Listener refused;
  second->Open(Session("alpha"), &refused);
  const absl::Status reason = refused.WaitForClose();
  EXPECT_EQ(reason.code(), absl::StatusCode::kAlreadyExists) << reason;
  EXPECT_THAT(std::string(reason.message()),
              AllOf(HasSubstr("alpha"), HasSubstr("--take-over"), HasSubstr("from ")));
  EXPECT_FALSE(first_listener.IsClosed());
  // The second process has its turn once the first has ended.
  first->Close();
  Listener granted;
  second->Open(Session("alpha"), &granted);
  EXPECT_TRUE(granted.WaitForGrant().has_value());
}

TEST_F(MapStoreServiceTest, AProcessTakesOverOnceIfItIsToldTo) {
  const auto first = MakeRemoteUplink(channel_);
  Listener first_listener;
  first->Open(Session("alpha"), &first_listener);
  ASSERT_TRUE(first_listener.WaitForGrant().has_value());
  const auto second = MakeOthersUplink(channel_, /*take_over=*/true);
  Listener second_listener;
  second->Open(Session("alpha"), &second_listener);
  ASSERT_TRUE(second_listener.WaitForGrant().has_value());
  EXPECT_TRUE(absl::IsAborted(first_listener.WaitForClose()));
  second->Close();
  Listener again;
  first->Open(Session("alpha"), &again);
  ASSERT_TRUE(again.WaitForGrant().has_value());
  Listener late;
  second->Open(Session("alpha"), &late);
  EXPECT_EQ(late.WaitForClose().code(), absl::StatusCode::kAlreadyExists);
}

// Keeps what the store's log says of the end of a session.
class Ends : public SyncObserver {
 public:
  void OnClosed(const SessionAgent&, const absl::Status& status) override {
    absl::MutexLock lock(&mutex_);
    ends_.push_back(status);
  }
  absl::Status WaitForOne() {
    absl::MutexLock lock(&mutex_);
    const auto come = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !ends_.empty(); };
    mutex_.AwaitWithTimeout(absl::Condition(&come), absl::Seconds(20));
    return ends_.empty() ? absl::DeadlineExceededError("no end") : ends_.front();
  }

 private:
  absl::Mutex mutex_;
  std::vector<absl::Status> ends_ ABSL_GUARDED_BY(mutex_);
};

TEST_F(MapStoreServiceTest, ARobotThatLeavesDoesNotLookLikeABrokenStream) {
  Ends ends;
  MapStoreServiceOptions options;
  options.observers = {&ends};
  MapStoreService service(store_.get(), options);
  const auto server = Server::Start("127.0.0.1:0", {&service});
  ASSERT_TRUE(server.ok()) << server.status();
  {
    const auto uplink = MakeRemoteUplink(MakeChannel((*server)->address()));
    Listener listener;
    uplink->Open(Session("alpha"), &listener);
    ASSERT_TRUE(listener.WaitForGrant().has_value());
    std::mt19937 random(3);
    ASSERT_TRUE(uplink->Send(MakeBatch(random, kMap, 1)));
    EXPECT_EQ(listener.WaitForAcknowledgements(1), 1u);
    uplink->Close();
    EXPECT_FALSE(listener.IsClosed());
  }
  EXPECT_EQ(ends.WaitForOne(), absl::OkStatus());
}

TEST_F(MapStoreServiceTest, AMalformedBatchEndsItsStreamAndNoOther) {
  const auto other = MakeRemoteUplink(channel_);
  Listener other_listener;
  other->Open(Session("beta"), &other_listener);
  ASSERT_TRUE(other_listener.WaitForGrant().has_value());

  std::mt19937 random(1);
  CameraBook sent;
  v1::SyncRequest request;
  *request.mutable_batch() = ToProto(MakeBatch(random, kMap, 1), sent, kPartBytes)[0];
  request.mutable_batch()
      ->mutable_full_keyframes(1)
      ->mutable_payload()
      ->mutable_features()
      ->mutable_octaves()
      ->at(3) = 9;
  grpc::ClientContext context;
  const auto stream = stub_->Sync(&context);
  v1::SyncRequest open;
  ToProto(Session("alpha"), open.mutable_open());
  stream->Write(open);
  stream->Write(request);
  v1::SyncResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_TRUE(response.has_grant());
  while (stream->Read(&response)) EXPECT_FALSE(response.has_acknowledgement());
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("c0ffee00c0ffee01:11"));
  EXPECT_THAT(status.error_message(), HasSubstr("octaves[3] is 9, must be in [0, 7]"));
  EXPECT_EQ(CountKeyframes(), 0u);

  ASSERT_TRUE(other->Send(MakeBatch(random, kOtherMap, 1)));
  EXPECT_EQ(other_listener.WaitForAcknowledgements(1), 1u);
  EXPECT_EQ(CountKeyframes(), 2u);
}

TEST_F(MapStoreServiceTest, SomebodyElsesLocalMapIsDenied) {
  Upload("alpha", kMap, 1);
  std::mt19937 random(2);
  const auto uplink = MakeRemoteUplink(channel_);
  Listener listener;
  uplink->Open(Session("beta"), &listener);
  ASSERT_TRUE(listener.WaitForGrant().has_value());
  ASSERT_TRUE(uplink->Send(MakeBatch(random, kMap, 2)));
  const absl::Status reason = listener.WaitForClose();
  ASSERT_TRUE(listener.IsClosed());
  EXPECT_EQ(reason.code(), absl::StatusCode::kPermissionDenied) << reason;
  EXPECT_EQ(CountKeyframes(), 2u);
}

// Returns the status of a stream that sends `first`.
grpc::Status SyncWith(v1::MapStore::Stub& stub, const v1::SyncRequest& first) {
  grpc::ClientContext context;
  const auto stream = stub.Sync(&context);
  stream->Write(first);
  v1::SyncResponse response;
  while (stream->Read(&response)) {
  }
  return stream->Finish();
}

TEST_F(MapStoreServiceTest, AStreamMustBeginWithAGoodOpening) {
  v1::SyncRequest batch;
  batch.mutable_batch()->set_number(1);
  EXPECT_EQ(SyncWith(*stub_, batch).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(SyncWith(*stub_, {}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  v1::SyncRequest open;
  open.mutable_open()->set_mission("not a mission");
  const grpc::Status status = SyncWith(*stub_, open);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("missions/{mission}"));
}

TEST_F(MapStoreServiceTest, ClosingTheSendingSideEndsTheSessionAfterTheLastAcknowledgement) {
  std::mt19937 random(3);
  CameraBook sent;
  grpc::ClientContext context;
  const auto stream = stub_->Sync(&context);
  v1::SyncRequest open;
  ToProto(Session("alpha"), open.mutable_open());
  stream->Write(open);
  // The batch is sent in many parts.
  for (const auto& part : ToProto(MakeBatch(random, kMap, 1, 5, 200), sent, 1000)) {
    v1::SyncRequest request;
    *request.mutable_batch() = part;
    stream->Write(request);
  }
  stream->WritesDone();
  v1::SyncResponse response;
  uint64_t acknowledged = 0;
  while (stream->Read(&response)) {
    if (response.has_acknowledgement()) acknowledged = response.acknowledgement().number();
  }
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(acknowledged, 1u);
  EXPECT_EQ(CountKeyframes(), 5u);
}

TEST_F(MapStoreServiceTest, ListsArePaged) {
  Upload("alpha", kMap, 3);
  v1::ListKeyframesRequest request;
  request.set_parent("missions/m/localMaps/-");
  request.set_page_size(4);
  std::vector<std::string> names;
  do {
    grpc::ClientContext context;
    v1::ListKeyframesResponse response;
    ASSERT_TRUE(stub_->ListKeyframes(&context, request, &response).ok());
    EXPECT_LE(response.keyframes_size(), 4);
    for (const auto& keyframe : response.keyframes()) names.push_back(keyframe.name());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(names.size(), 6u);
  EXPECT_THAT(names, Contains("missions/m/localMaps/c0ffee00c0ffee01/keyframes/31"));
  request.set_page_size(-1);
  grpc::ClientContext context;
  v1::ListKeyframesResponse response;
  const grpc::Status status = stub_->ListKeyframes(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("page_size is -1"));
}

TEST_F(MapStoreServiceTest, AKeyframeComesWithWhatTheCameraSawIfWanted) {
  Upload("alpha", kMap, 1);
  v1::GetKeyframeRequest request;
  request.set_name("missions/m/localMaps/c0ffee00c0ffee01/keyframes/10");
  v1::Keyframe keyframe;
  grpc::ClientContext basic;
  ASSERT_TRUE(stub_->GetKeyframe(&basic, request, &keyframe).ok());
  EXPECT_FALSE(keyframe.has_payload());
  EXPECT_EQ(keyframe.agent(), "missions/m/agents/alpha");
  EXPECT_EQ(keyframe.keypoints(), 30u);
  EXPECT_EQ(keyframe.sights_size(), 0);
  request.set_view(v1::KEYFRAME_VIEW_FULL);
  grpc::ClientContext full;
  ASSERT_TRUE(stub_->GetKeyframe(&full, request, &keyframe).ok());
  EXPECT_EQ(keyframe.payload().features().x_px64_size(), 30);
  EXPECT_GT(keyframe.observed_points(), 0u);
  EXPECT_EQ(static_cast<uint32_t>(keyframe.sights_size()), keyframe.observed_points());
  EXPECT_EQ(keyframe.sights(0).local_map(), kMap.value);
}

TEST_F(MapStoreServiceTest, WatchersSeeWhatThereIsAndWhatComes) {
  Upload("alpha", kMap, 1);
  grpc::ClientContext context;
  v1::WatchMapRequest request;
  request.set_mission("missions/m");
  request.set_include_points(true);
  const auto stream = stub_->WatchMap(&context, request);
  v1::WatchMapResponse change;
  ASSERT_TRUE(stream->Read(&change));
  ASSERT_EQ(change.islands_size(), 1);
  EXPECT_EQ(change.islands(0).keyframes_size(), 2);
  EXPECT_GT(change.islands(0).points().ids().index_deltas_size(), 0);
  EXPECT_EQ(change.islands(0).point_observations_size(),
            change.islands(0).points().ids().index_deltas_size());
  EXPECT_THAT(change.local_map_agents(), Contains("alpha"));
  const uint64_t version = change.version();
  Upload("beta", kOtherMap, 1);
  bool seen = false;
  while (!seen && stream->Read(&change)) {
    EXPECT_GT(change.version(), version);
    seen = std::ranges::find(change.local_map_agents(), "beta") != change.local_map_agents().end();
  }
  EXPECT_TRUE(seen);
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(MapStoreServiceTest, WatchersHearThatTheMissionWasDeleted) {
  Upload("alpha", kMap, 1);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
  v1::WatchMapRequest request;
  request.set_mission("missions/m");
  const auto stream = stub_->WatchMap(&context, request);
  v1::WatchMapResponse change;
  ASSERT_TRUE(stream->Read(&change));
  ASSERT_TRUE(store_->DeleteMission("m").ok());
  while (stream->Read(&change)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(MapStoreServiceTest, OverlapsOfAnotherMissionsLocalMapAreNotLookedFor) {
  Upload("alpha", kMap, 1);
  grpc::ClientContext context;
  v1::ListOverlapsRequest request;
  request.set_parent("missions/m");
  request.set_local_map("missions/other/localMaps/c0ffee00c0ffee01");
  v1::ListOverlapsResponse response;
  EXPECT_EQ(stub_->ListOverlaps(&context, request, &response).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(MapStoreServiceTest, WatchingAnUnknownMissionIsRefused) {
  grpc::ClientContext context;
  v1::WatchMapRequest request;
  request.set_mission("missions/nothing");
  const auto stream = stub_->WatchMap(&context, request);
  v1::WatchMapResponse change;
  EXPECT_FALSE(stream->Read(&change));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(MapStoreServiceTest, DeletingAMissionEndsItsSessions) {
  Upload("alpha", kMap, 1);
  const auto uplink = MakeRemoteUplink(channel_);
  Listener listener;
  uplink->Open(Session("alpha"), &listener);
  ASSERT_TRUE(listener.WaitForGrant().has_value());
  grpc::ClientContext context;
  v1::DeleteMissionRequest request;
  request.set_name("missions/m");
  v1::DeleteMissionResponse response;
  ASSERT_TRUE(stub_->DeleteMission(&context, request, &response).ok());
  EXPECT_EQ(response.local_maps(), 1u);
  const absl::Status reason = listener.WaitForClose();
  ASSERT_TRUE(listener.IsClosed());
  EXPECT_EQ(reason.code(), absl::StatusCode::kAborted) << reason;
}

TEST_F(MapStoreServiceTest, AServerThatStopsEndsItsStreamsAtOnce) {
  Upload("alpha", kMap, 1);
  const auto uplink = MakeRemoteUplink(channel_);
  Listener listener;
  uplink->Open(Session("alpha"), &listener);
  ASSERT_TRUE(listener.WaitForGrant().has_value());
  grpc::ClientContext context;
  v1::WatchMapRequest request;
  request.set_mission("missions/m");
  const auto watch = stub_->WatchMap(&context, request);
  v1::WatchMapResponse change;
  ASSERT_TRUE(watch->Read(&change));

  const absl::Time begin = absl::Now();
  service_->EndStreams();
  const absl::Status reason = listener.WaitForClose();
  EXPECT_TRUE(absl::IsUnavailable(reason)) << reason;
  EXPECT_THAT(std::string(reason.message()), HasSubstr("stopping"));
  while (watch->Read(&change)) {
  }
  EXPECT_EQ(watch->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  Listener late;
  uplink->Open(Session("alpha"), &late);
  EXPECT_TRUE(absl::IsUnavailable(late.WaitForClose()));
  server_->Shutdown(absl::Minutes(5));
  EXPECT_LT(absl::Now() - begin, absl::Minutes(1)) << "nothing was left to wait for";
}

TEST_F(MapStoreServiceTest, StatisticsCountWhatCrossedTheWire) {
  Upload("alpha", kMap, 2);
  grpc::ClientContext context;
  v1::GetStatisticsRequest request;
  request.set_mission("missions/m");
  v1::GetStatisticsResponse response;
  ASSERT_TRUE(stub_->GetStatistics(&context, request, &response).ok());
  const v1::TransferStatistics& transfer = response.mission().transfer();
  EXPECT_EQ(transfer.full_keyframes().count(), 4u);
  EXPECT_GT(transfer.full_keyframes().bytes(), 4u * 30 * 32);
  EXPECT_LT(transfer.full_keyframes().bytes(), 4u * 30 * 64);
  EXPECT_GT(response.server().peak_rss_bytes(), 1u << 20);
}

TEST_F(MapStoreServiceTest, AClientThatKnowsNoProtoAsksForTheTrajectories) {
  Upload("alpha", kMap, 1);
  GenericClient client(channel_);
  const auto services = client.ListServices();
  ASSERT_TRUE(services.ok()) << services.status();
  EXPECT_THAT(*services, Contains("corbslam.v1.MapStore"));
  EXPECT_THAT(*services, Contains("grpc.health.v1.Health"));
  const auto local = client.Call("corbslam.v1.MapStore/GetTrajectory",
                                 R"({"name": "missions/m/agents/-", "frame": 1})");
  ASSERT_TRUE(local.ok()) << local.status();
  ASSERT_EQ(local->size(), 1u);
  EXPECT_THAT((*local)[0], HasSubstr(R"("agent": "missions/m/agents/alpha")"));
  EXPECT_THAT((*local)[0], HasSubstr(R"("timestampNs": "1000000000000")"));
  const auto keyframes =
      client.Call("corbslam.v1.MapStore/ListKeyframes", R"({"parent": "missions/m/localMaps/-"})");
  ASSERT_TRUE(keyframes.ok()) << keyframes.status();
  EXPECT_THAT((*keyframes)[0], HasSubstr("localMaps/c0ffee00c0ffee01/keyframes/11"));
  const auto no_frame =
      client.Call("corbslam.v1.MapStore/GetTrajectory", R"({"name": "missions/m/agents/-"})");
  EXPECT_EQ(no_frame.status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace corbslam::services
