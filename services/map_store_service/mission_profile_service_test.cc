// Tests missions that are made ahead and changed, through the real stubs in one process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
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

// A clock that stands until it is set, and counts how often it was read.
class StandingClock {
 public:
  absl::Time Now() {
    absl::MutexLock lock(&mutex_);
    ++readings_;
    return now_;
  }
  void Advance(absl::Duration by) {
    absl::MutexLock lock(&mutex_);
    now_ += by;
  }
  // Waits until somebody has read it so often again.
  void AwaitReadings(int more) {
    absl::MutexLock lock(&mutex_);
    const int enough = readings_ + more;
    const auto has_been_read = [this, enough]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return readings_ >= enough;
    };
    mutex_.Await(absl::Condition(&has_been_read));
  }

 private:
  absl::Mutex mutex_;
  absl::Time now_ ABSL_GUARDED_BY(mutex_) = absl::FromUnixSeconds(1'700'000'000);
  int readings_ ABSL_GUARDED_BY(mutex_) = 0;
};

class CountingObserver : public SyncObserver {
 public:
  void OnReceived(const SessionAgent&, size_t) override { ++received; }
  std::atomic<int> received = 0;
};

class MissionProfileServiceTest : public ::testing::Test {
 protected:
  MissionProfileServiceTest() {
    store_ =
        std::make_unique<MapStore>(MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(),
                                   nullptr, [this] { return clock_.Now(); });
    MapStoreServiceOptions options;
    options.observers = {&observer_};
    service_ = std::make_unique<MapStoreService>(store_.get(), options);
    server_ = *Server::Start("", {service_.get()});
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  grpc::Status Create(const v1::Mission& mission, v1::Mission* made = nullptr) {
    grpc::ClientContext context;
    v1::CreateMissionRequest request;
    *request.mutable_mission() = mission;
    v1::Mission ignored;
    return stub_->CreateMission(&context, request, made == nullptr ? &ignored : made);
  }
  grpc::Status Update(const v1::Mission& mission, const std::vector<std::string>& paths,
                      v1::Mission* changed = nullptr) {
    grpc::ClientContext context;
    v1::UpdateMissionRequest request;
    *request.mutable_mission() = mission;
    for (const std::string& path : paths) request.mutable_update_mask()->add_paths(path);
    v1::Mission ignored;
    return stub_->UpdateMission(&context, request, changed == nullptr ? &ignored : changed);
  }
  static void ExpectRefused(const grpc::Status& status, grpc::StatusCode code,
                            const std::string& says) {
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(says));
  }

  StandingClock clock_;
  CountingObserver observer_;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

v1::Mission MakeMission() {
  v1::Mission mission;
  mission.set_name("missions/lab");
  mission.set_description("the old mine");
  (*mission.mutable_labels())["site"] = "3";
  mission.mutable_limits()->set_keyframes(500);
  mission.mutable_limits()->set_uplink_bytes_per_second(10'000);
  (*mission.mutable_agent_limits())["alpha"].set_keyframes(50);
  mission.set_retention_s(86'400);
  mission.mutable_origin()->set_latitude_deg(-33.5);
  mission.mutable_origin()->set_heading_deg(90);
  return mission;
}

TEST_F(MissionProfileServiceTest, MakesWhatWasAskedFor) {
  v1::Mission made;
  v1::Mission wanted = MakeMission();
  wanted.set_keyframes(77);  // Only the store says this.
  ASSERT_TRUE(Create(wanted, &made).ok());
  EXPECT_EQ(made.keyframes(), 0u);
  EXPECT_EQ(made.description(), "the old mine");
  EXPECT_EQ(made.labels().at("site"), "3");
  EXPECT_EQ(made.limits().keyframes(), 500u);
  EXPECT_EQ(made.agent_limits().at("alpha").keyframes(), 50u);
  EXPECT_EQ(made.retention_s(), 86'400u);
  EXPECT_EQ(made.origin().latitude_deg(), -33.5);
  EXPECT_EQ(made.created_ns(), absl::ToUnixNanos(clock_.Now()));
  EXPECT_EQ(made.last_used_ns(), made.created_ns());
  ExpectRefused(Create(wanted), grpc::StatusCode::ALREADY_EXISTS, "mission lab");
}

TEST_F(MissionProfileServiceTest, SaysWhatIsWrongWithIt) {
  using Code = grpc::StatusCode;
  ExpectRefused(Create(v1::Mission()), Code::INVALID_ARGUMENT, "missions/{mission}");
  v1::Mission mission = MakeMission();
  mission.set_name("missions/a b");
  ExpectRefused(Create(mission), Code::INVALID_ARGUMENT, "a b");
  mission = MakeMission();
  mission.mutable_origin()->set_longitude_deg(std::numeric_limits<double>::quiet_NaN());
  ExpectRefused(Create(mission), Code::INVALID_ARGUMENT, "origin.longitude_deg is nan");
  mission = MakeMission();
  (*mission.mutable_agent_limits())["missions/lab/agents/alpha"];
  ExpectRefused(Create(mission), Code::INVALID_ARGUMENT, "missions/lab/agents/alpha");
  EXPECT_EQ(store_->ListMissions({})->items.size(), 0u);
}

// A client makes this of -1.
TEST_F(MissionProfileServiceTest, NoLimitIsBeyondAllThatThereIs) {
  using Code = grpc::StatusCode;
  constexpr uint64_t kMinusOne = std::numeric_limits<uint64_t>::max();
  v1::Mission mission = MakeMission();
  mission.mutable_limits()->set_keyframes(kMinusOne);
  ExpectRefused(Create(mission), Code::INVALID_ARGUMENT,
                "limits.keyframes is 18446744073709551615");
  mission = MakeMission();
  mission.mutable_limits()->set_disk_bytes(kMinusOne);
  ExpectRefused(Create(mission), Code::INVALID_ARGUMENT, "limits.disk_bytes");
  mission = MakeMission();
  (*mission.mutable_agent_limits())["alpha"].set_keyframes(kMinusOne);
  ExpectRefused(Create(mission), Code::INVALID_ARGUMENT, "agent_limits[alpha].keyframes");
  mission = MakeMission();
  mission.set_retention_s(kMinusOne);
  ExpectRefused(Create(mission), Code::INVALID_ARGUMENT, "retention_s");
}

TEST_F(MissionProfileServiceTest, ChangesOnlyWhatTheMaskNames) {
  using Code = grpc::StatusCode;
  ASSERT_TRUE(Create(MakeMission()).ok());
  v1::Mission values;
  values.set_name("missions/lab");
  values.set_description("new");
  v1::Mission changed;
  ASSERT_TRUE(Update(values, {"description", "limits"}, &changed).ok());
  EXPECT_EQ(changed.description(), "new");
  EXPECT_FALSE(changed.has_limits());
  EXPECT_EQ(changed.labels().size(), 1u);
  EXPECT_TRUE(changed.has_origin());
  ASSERT_TRUE(Update(values, {"origin", "labels", "agent_limits", "retention_s"}, &changed).ok());
  EXPECT_FALSE(changed.has_origin());
  EXPECT_TRUE(changed.labels().empty());
  EXPECT_TRUE(changed.agent_limits().empty());
  EXPECT_EQ(changed.retention_s(), 0u);
  ExpectRefused(Update(values, {}), Code::INVALID_ARGUMENT, "update_mask is empty");
  ExpectRefused(Update(values, {"description", "keyframes"}), Code::INVALID_ARGUMENT,
                "update_mask has \"keyframes\"");
  ExpectRefused(Update(values, {"limits.keyframes"}), Code::INVALID_ARGUMENT, "limits.keyframes");
  ExpectRefused(Update(values, {"*"}), Code::INVALID_ARGUMENT, "\"*\"");
  values.set_name("missions/moon");
  ExpectRefused(Update(values, {"description"}), Code::NOT_FOUND, "moon");
}

TEST_F(MissionProfileServiceTest, AListOfLargeMissionsHasPagesThatFitIntoMessages) {
  v1::Mission mission = MakeMission();
  for (int i = 0; i < 999; ++i) {
    v1::MissionLimits& limits =
        (*mission.mutable_agent_limits())[absl::StrCat(std::string(50, 'a'), i)];
    limits.set_keyframes(uint64_t{1} << 50);
    limits.set_uplink_bytes_per_second(uint64_t{1} << 50);
  }
  constexpr size_t kMissions = 60;
  for (size_t i = 0; i < kMissions; ++i) {
    mission.set_name(absl::StrCat("missions/m", i));
    ASSERT_TRUE(Create(mission).ok());
  }
  ASSERT_GT(kMissions * mission.ByteSizeLong(), 4u << 20);
  std::set<std::string> listed;
  v1::ListMissionsRequest request;
  int pages = 0;
  do {
    grpc::ClientContext context;
    v1::ListMissionsResponse response;
    const grpc::Status status = stub_->ListMissions(&context, request, &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
    ASSERT_FALSE(response.missions().empty());
    for (const v1::Mission& one : response.missions()) {
      EXPECT_TRUE(listed.insert(one.name()).second) << one.name();
    }
    request.set_page_token(response.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_EQ(listed.size(), kMissions);
  EXPECT_GT(pages, 1);
}

// An agent of a mission of which a second may bring a MiB.
class HeldAgentTest : public MissionProfileServiceTest {
 protected:
  // Opens the session, and spends all but a few bytes of the burst.
  void Open(const SessionRequest& open) {
    v1::Mission mission = MakeMission();
    mission.mutable_limits()->set_uplink_bytes_per_second(uint64_t{1} << 20);
    ASSERT_TRUE(Create(mission).ok());
    stream_ = stub_->Sync(&context_);
    v1::SyncRequest request;
    ToProto(open, request.mutable_open());
    ASSERT_TRUE(stream_->Write(request));
    ASSERT_TRUE(stream_->Read(&response_));
    ASSERT_TRUE(response_.has_grant());
    opened_ = observer_.received;
    // The store counts its sessions from 1.
    EXPECT_EQ(store_->PaceUplink(1, (1 << 20) - 10), absl::ZeroDuration());
  }
  // `send` sends the message of a number; `answered` returns the number that a response answers, 0
  // for any other.
  void ExpectTheSecondWaits(const std::function<void(uint64_t)>& send,
                            const std::function<uint64_t(const v1::SyncResponse&)>& answered) {
    send(1);
    // What is not read fills the transport's window, and the writer waits.
    std::thread second([&send] { send(2); });
    // Shared updates may come between.
    const auto next_answer = [&]() -> uint64_t {
      while (stream_->Read(&response_)) {
        if (const uint64_t number = answered(response_); number > 0) return number;
      }
      return 0;
    };
    EXPECT_EQ(next_answer(), 1u);
    clock_.AwaitReadings(5);
    EXPECT_EQ(observer_.received, opened_ + 1);
    clock_.Advance(absl::Seconds(1));
    EXPECT_EQ(next_answer(), 2u);
    second.join();
    context_.TryCancel();
    stream_->Finish();
  }

  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::SyncRequest, v1::SyncResponse>> stream_;
  v1::SyncResponse response_;
  int opened_ = 0;
};

TEST_F(HeldAgentTest, WhoSendsTooFastIsReadNoMoreUntilItIsPaid) {
  ASSERT_NO_FATAL_FAILURE(
      Open({.mission = "lab", .agent = "alpha", .last_revision = 0, .local_maps = {}}));
  std::mt19937 random(1);
  CameraBook sent;
  const auto send = [&](uint64_t number) {
    for (auto& part :
         ToProto(test_data::MakeBatch(random, test_data::kMap, number), sent, 1 << 20)) {
      v1::SyncRequest batch;
      *batch.mutable_batch() = std::move(part);
      EXPECT_TRUE(stream_->Write(batch));
    }
  };
  ExpectTheSecondWaits(
      send, [](const v1::SyncResponse& said) { return said.acknowledgement().number(); });
}

TEST_F(HeldAgentTest, WhoOnlyLocalisesIsHeldLikewise) {
  SessionRequest open;
  open.mission = "lab";
  open.agent = "guest";
  open.localise_only = true;
  ASSERT_NO_FATAL_FAILURE(Open(open));
  LocalisedFrames part;
  part.run = 7;
  for (int64_t i = 0; i < 100; ++i) {
    part.tracked_frames.push_back({i, {{1}, 0}, Rigid3d::Identity()});
  }
  const auto send = [&](uint64_t number) {
    part.number = number;
    v1::SyncRequest said;
    ToProto(part, said.mutable_localised());
    EXPECT_TRUE(stream_->Write(said));
  };
  ExpectTheSecondWaits(send,
                       [](const v1::SyncResponse& said) { return said.localised_kept().number(); });
}

}  // namespace
}  // namespace corbslam::services
