// Tests that a mission's past is told to who asks, and what it may cost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
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

// Lets replays wait until the test says so.
class HeldUpJournal : public testing::ByteJournal {
 public:
  using testing::ByteJournal::ByteJournal;

  void HoldUp() { is_held_up_ = true; }
  void GoOn() { go_on_.Notify(); }
  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override {
    if (is_held_up_) go_on_.WaitForNotification();
    return ByteJournal::Recover(mission, replay);
  }

 private:
  std::atomic<bool> is_held_up_ = false;
  mutable absl::Notification go_on_;
};

class ReplayMapTest : public ::testing::Test {
 protected:
  // One call that reads a replay.
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<v1::WatchMapResponse>> stream;
    std::vector<v1::WatchMapResponse> messages;

    grpc::Status ReadAll() {
      while (stream->Read(&messages.emplace_back())) {
      }
      messages.pop_back();
      return stream->Finish();
    }
    // Returns the revisions that were told whole.
    std::vector<uint64_t> Revisions() const {
      std::vector<uint64_t> revisions;
      for (const v1::WatchMapResponse& message : messages) {
        if (!message.continues()) revisions.push_back(message.revision());
      }
      return revisions;
    }
  };

  void SetUp() override {
    auto journal = std::make_unique<HeldUpJournal>(std::make_shared<testing::JournalBytes>());
    journal_ = journal.get();
    for (const auto& record : testing::MakeSmallMission()) {
      ASSERT_TRUE(journal->Append("m", record).ok());
    }
    MapStoreOptions options;
    // Nothing but what the test does happens to the mission.
    options.deterministic = true;
    store_ = std::make_unique<MapStore>(options, nullptr, std::move(journal), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  std::unique_ptr<Call> Ask(uint32_t max_moments, const std::string& mission = "missions/m") {
    auto call = std::make_unique<Call>();
    v1::ReplayMapRequest request;
    request.set_mission(mission);
    request.set_include_points(true);
    request.set_max_moments(max_moments);
    call->stream = stub_->ReplayMap(&call->context, request);
    return call;
  }
  grpc::Status GetMission() {
    grpc::ClientContext context;
    v1::GetMissionRequest request;
    request.set_name("missions/m");
    v1::Mission mission;
    return stub_->GetMission(&context, request, &mission);
  }

  HeldUpJournal* journal_ = nullptr;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(ReplayMapTest, TellsOneMomentAfterTheOther) {
  const auto call = Ask(0);
  const grpc::Status status = call->ReadAll();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_THAT(call->Revisions(), ElementsAre(0, 0, 1, 1, 2));
  const v1::WatchMapResponse& first = call->messages.front();
  ASSERT_EQ(first.islands_size(), 1);
  EXPECT_TRUE(first.islands(0).anew());
  EXPECT_EQ(first.islands(0).keyframes_size(), 4);
  EXPECT_GT(first.islands(0).points().ids().index_deltas_size(), 0);
  EXPECT_THAT(first.local_map_agents(), ElementsAre("a"));
  EXPECT_FALSE(call->messages.back().continues());
}

TEST_F(ReplayMapTest, TellsAsManyMomentsAsAreWanted) {
  const auto call = Ask(2);
  ASSERT_TRUE(call->ReadAll().ok());
  EXPECT_THAT(call->Revisions(), ElementsAre(0, 2));
}

TEST_F(ReplayMapTest, RefusesWhatItCannotTell) {
  for (const uint32_t bad : {1u, 1001u}) {
    const grpc::Status status = Ask(bad)->ReadAll();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(status.error_message(),
              "max_moments is " + std::to_string(bad) + ", must be 2 to 1000");
  }
  EXPECT_EQ(Ask(0, "missions/nobodys")->ReadAll().error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Ask(0, "m")->ReadAll().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(ReplayMapTest, AFewAtATimeAndNobodyElseWaits) {
  journal_->HoldUp();
  std::vector<std::unique_ptr<Call>> calls;
  for (size_t i = 0; i < MapStoreService::kMaxReplays; ++i) calls.push_back(Ask(0));
  while (service_->replays().taken() < MapStoreService::kMaxReplays) {
    absl::SleepFor(absl::Milliseconds(1));
  }
  const grpc::Status status = Ask(0)->ReadAll();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("try again"));
  EXPECT_TRUE(GetMission().ok()) << "look-ups go on";
  journal_->GoOn();
  for (const auto& call : calls) EXPECT_TRUE(call->ReadAll().ok());
  EXPECT_EQ(service_->replays().taken(), 0u);
  EXPECT_EQ(service_->streams().open_streams(), 0u);
  EXPECT_TRUE(Ask(0)->ReadAll().ok());
}

TEST_F(ReplayMapTest, EndsWhenTheCallerGoes) {
  journal_->HoldUp();
  const auto call = Ask(0);
  while (service_->replays().taken() == 0) absl::SleepFor(absl::Milliseconds(1));
  call->context.TryCancel();
  EXPECT_EQ(call->ReadAll().error_code(), grpc::StatusCode::CANCELLED);
  journal_->GoOn();
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (service_->replays().taken() > 0 && absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(1));
  }
  EXPECT_EQ(service_->replays().taken(), 0u);
}

}  // namespace
}  // namespace corbslam::services
