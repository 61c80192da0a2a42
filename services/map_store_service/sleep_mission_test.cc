// Tests that calls and streams wait for a mission that is asleep without holding threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/testing/journal_wrapper.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"
#include "services/testing/test_path.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::Journal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::RocksJournal;

namespace {

namespace fs = std::filesystem;
using test_data::MakeBatch;
using ::testing::HasSubstr;

// A journal in which reading a mission takes until it is let go.
class SlowJournal : public corbslam::testing::JournalWrapper {
 public:
  explicit SlowJournal(std::unique_ptr<Journal> journal) : JournalWrapper(std::move(journal)) {}

  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override {
    if (slow && replay.with_features) let_go.WaitForNotification();
    return JournalWrapper::Recover(mission, replay);
  }

  std::atomic<bool> slow = false;
  absl::Notification let_go;
};

MapStoreOptions SleepyOptions() {
  MapStoreOptions options;
  options.sleep_after_s = 600;
  options.wake_in_background = true;
  return options;
}

class SleepMissionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    auto journal = RocksJournal::Open({.directory = folder_.string()});
    ASSERT_TRUE(journal.ok()) << journal.status();
    auto slow = std::make_unique<SlowJournal>(*std::move(journal));
    journal_ = slow.get();
    store_ = std::make_unique<MapStore>(SleepyOptions(), nullptr, std::move(slow), nullptr);
    MapStoreServiceOptions options;
    options.threads = 1;
    service_ = std::make_unique<MapStoreService>(store_.get(), options);
    server_ = *Server::Start("", {service_.get()});
    channel_ = server_->InProcessChannel();
    stub_ = v1::MapStore::NewStub(channel_);
    for (const std::string mission : {"m", "other"}) Upload(mission, 1);
    Sleep();
  }
  void TearDown() override {
    server_->Shutdown(absl::ZeroDuration());
    stub_.reset();
    channel_.reset();
    server_.reset();
    service_.reset();
    store_.reset();
    fs::remove_all(folder_);
  }

  static SessionRequest Session(const std::string& mission) {
    SessionRequest request;
    request.mission = mission;
    request.agent = "alpha";
    request.local_maps = {test_data::kMap};
    return request;
  }
  // Stores the batch with this number, and ends the session.
  void Upload(const std::string& mission, uint64_t number) {
    std::mt19937 random(7);
    MapUpdateBatch batch;
    for (uint64_t i = 1; i <= number; ++i) batch = MakeBatch(random, test_data::kMap, i);
    const auto opened = store_->OpenSession(Session(mission));
    ASSERT_TRUE(opened.ok()) << opened.status();
    ASSERT_TRUE(store_->Apply(opened->session_id, batch).ok());
    store_->CloseSession(opened->session_id);
  }
  grpc::Status SleepStatus(const std::string& name, v1::Mission* mission) {
    grpc::ClientContext context;
    v1::SleepMissionRequest request;
    request.set_name(name);
    return stub_->SleepMission(&context, request, mission);
  }
  void Sleep() {
    v1::Mission mission;
    const grpc::Status slept = SleepStatus("missions/m", &mission);
    ASSERT_TRUE(slept.ok()) << slept.error_message();
    EXPECT_TRUE(mission.asleep());
    EXPECT_EQ(mission.keyframes(), 2u);
  }
  grpc::Status ListAgents(const std::string& mission, grpc::ClientContext& context) {
    v1::ListAgentsRequest request;
    request.set_parent("missions/" + mission);
    v1::ListAgentsResponse response;
    return stub_->ListAgents(&context, request, &response);
  }
  v1::Mission GetMission() {
    grpc::ClientContext context;
    v1::GetMissionRequest request;
    request.set_name("missions/m");
    v1::Mission mission;
    EXPECT_TRUE(stub_->GetMission(&context, request, &mission).ok());
    return mission;
  }

  const fs::path folder_ = TestPath("sleep");
  SlowJournal* journal_ = nullptr;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(SleepMissionTest, SaysWhyNot) {
  v1::Mission mission;
  EXPECT_EQ(SleepStatus("missions/nowhere", &mission).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(SleepStatus("m", &mission).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_TRUE(SleepStatus("missions/m", &mission).ok()) << "it sleeps already";
  UplinkNotes notes;
  const auto uplink = MakeRemoteUplink(channel_);
  uplink->Open(Session("other"), &notes);
  ASSERT_TRUE(notes.WaitForGrant().has_value());
  const grpc::Status used = SleepStatus("missions/other", &mission);
  EXPECT_EQ(used.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(used.error_message(), HasSubstr("robots are connected"));
  uplink->Close();
}

TEST_F(SleepMissionTest, ARobotThatComesWakesIt) {
  UplinkNotes notes;
  const auto uplink = MakeRemoteUplink(channel_);
  uplink->Open(Session("m"), &notes);
  const auto grant = notes.WaitForGrant();
  ASSERT_TRUE(grant.has_value());
  ASSERT_EQ(grant->acknowledged.size(), 1u);
  EXPECT_EQ(grant->acknowledged[0].number, 1u);
  std::mt19937 random(7);
  MakeBatch(random, test_data::kMap, 1);
  ASSERT_TRUE(uplink->Send(MakeBatch(random, test_data::kMap, 2)));
  EXPECT_EQ(notes.WaitForAcknowledgements(1), 2u);
  EXPECT_FALSE(GetMission().asleep());
  EXPECT_EQ(GetMission().keyframes(), 4u);
  uplink->Close();
}

TEST_F(SleepMissionTest, EveryKindOfStreamWakesIt) {
  {
    grpc::ClientContext context;
    v1::WatchMapRequest request;
    request.set_mission("missions/m");
    const auto reader = stub_->WatchMap(&context, request);
    v1::WatchMapResponse response;
    EXPECT_TRUE(reader->Read(&response));
    context.TryCancel();
    reader->Finish();
  }
  // The store hears a little later that the watcher has gone.
  v1::Mission mission;
  while (!SleepStatus("missions/m", &mission).ok()) std::this_thread::yield();
  {
    grpc::ClientContext context;
    v1::WatchEventsRequest request;
    request.set_mission("missions/m");
    const auto reader = stub_->WatchEvents(&context, request);
    v1::MissionEvent event;
    EXPECT_TRUE(reader->Read(&event));
    EXPECT_EQ(event.number(), 1u) << "it is remembered";
    context.TryCancel();
    reader->Finish();
  }
  while (!SleepStatus("missions/m", &mission).ok()) std::this_thread::yield();
  {
    grpc::ClientContext context;
    v1::ReplayMapRequest request;
    request.set_mission("missions/m");
    const auto reader = stub_->ReplayMap(&context, request);
    v1::WatchMapResponse response;
    EXPECT_TRUE(reader->Read(&response));
    context.TryCancel();
    reader->Finish();
  }
  while (!SleepStatus("missions/m", &mission).ok()) std::this_thread::yield();
  grpc::ClientContext context;
  v1::BackupMissionRequest request;
  request.set_name("missions/m");
  const auto reader = stub_->BackupMission(&context, request);
  v1::BackupMissionResponse response;
  EXPECT_TRUE(reader->Read(&response));
  while (reader->Read(&response)) {
  }
  EXPECT_TRUE(reader->Finish().ok());
}

// There is one thread for batches and one for look-ups.
TEST_F(SleepMissionTest, NoThreadWaits) {
  journal_->slow = true;
  std::vector<std::thread> waiting;
  for (int i = 0; i < 4; ++i) {
    waiting.emplace_back([this] {
      grpc::ClientContext context;
      const grpc::Status status = ListAgents("m", context);
      EXPECT_TRUE(status.ok()) << status.error_message();
    });
  }
  UplinkNotes notes;
  const auto uplink = MakeRemoteUplink(channel_);
  uplink->Open(Session("m"), &notes);
  // Somebody who gave up is no trouble.
  grpc::ClientContext impatient;
  impatient.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(20));
  EXPECT_EQ(ListAgents("m", impatient).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  grpc::ClientContext context;
  const grpc::Status other = ListAgents("other", context);
  EXPECT_TRUE(other.ok()) << other.error_message();
  UplinkNotes others_notes;
  const auto others = MakeRemoteUplink(channel_);
  others->Open(Session("other"), &others_notes);
  EXPECT_TRUE(others_notes.WaitForGrant().has_value());
  EXPECT_TRUE(GetMission().asleep());
  journal_->let_go.Notify();
  for (std::thread& thread : waiting) thread.join();
  EXPECT_TRUE(notes.WaitForGrant().has_value());
  EXPECT_EQ(store_->sleep().woken, 1u);
  uplink->Close();
  others->Close();
}

TEST_F(SleepMissionTest, WhoeverWaitsHearsOfDamage) {
  const map_store::JournalFolder folder(folder_.string());
  for (const auto& entry : fs::directory_iterator(folder.PathOf("m"))) {
    if (entry.path().extension() == ".sst") fs::resize_file(entry.path(), 10);
  }
  grpc::ClientContext context;
  const grpc::Status damaged = ListAgents("m", context);
  EXPECT_EQ(damaged.error_code(), grpc::StatusCode::DATA_LOSS) << damaged.error_message();
  UplinkNotes notes;
  const auto uplink = MakeRemoteUplink(channel_);
  uplink->Open(Session("m"), &notes);
  EXPECT_TRUE(absl::IsDataLoss(notes.WaitForClose()));
  EXPECT_NE(GetMission().damage(), "");
}

}  // namespace
}  // namespace corbslam::services
