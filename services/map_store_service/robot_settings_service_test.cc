// Tests settings of robots through the real stubs and an agent's stream in one process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/synchronization/mutex.h"
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
using ::testing::SizeIs;

// Holds the settings that an uplink was told.
class ToldSettings {
 public:
  void Add(const v1::RobotSettingsList& list) {
    absl::MutexLock lock(&mutex_);
    told_.push_back(list);
  }
  v1::RobotSettingsList Await(size_t number) {
    absl::MutexLock lock(&mutex_);
    const auto has = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return told_.size() >= number; };
    mutex_.Await(absl::Condition(&has));
    return told_[number - 1];
  }

 private:
  absl::Mutex mutex_;
  std::vector<v1::RobotSettingsList> told_ ABSL_GUARDED_BY(mutex_);
};

class RobotSettingsServiceTest : public ::testing::Test {
 protected:
  RobotSettingsServiceTest()
      : store_(MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr),
        service_(&store_),
        server_(*Server::Start("", {&service_})),
        stub_(v1::MapStore::NewStub(server_->InProcessChannel())) {
    EXPECT_TRUE(store_.CreateMission("lab", {}).ok());
  }
  ~RobotSettingsServiceTest() override { server_->Shutdown(absl::ZeroDuration()); }

  static v1::SignedRobotSettings Make(uint64_t version, const std::string& agent = "") {
    v1::RobotSettings settings;
    settings.set_mission("missions/lab");
    settings.set_agent(agent);
    settings.set_version(version);
    v1::SignedRobotSettings made;
    made.set_settings(settings.SerializeAsString());
    made.set_signature(std::string(64, 's'));
    return made;
  }
  grpc::Status Set(const std::string& name, const v1::SignedRobotSettings& settings) {
    grpc::ClientContext context;
    v1::SetRobotSettingsRequest request;
    request.set_name(name);
    *request.mutable_settings() = settings;
    v1::RobotSettingsList ignored;
    return stub_->SetRobotSettings(&context, request, &ignored);
  }
  v1::RobotSettingsList Get(const std::string& name) {
    grpc::ClientContext context;
    v1::GetRobotSettingsRequest request;
    request.set_name(name);
    v1::RobotSettingsList found;
    const grpc::Status status = stub_->GetRobotSettings(&context, request, &found);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return found;
  }
  static void ExpectRefused(const grpc::Status& status, grpc::StatusCode code,
                            const std::string& says) {
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(says));
  }

  MapStore store_;
  MapStoreService service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(RobotSettingsServiceTest, HandsOnTheBytesThatWereSigned) {
  ASSERT_TRUE(Set("missions/lab", Make(1)).ok());
  ASSERT_TRUE(Set("missions/lab/agents/alpha", Make(7, "alpha")).ok());
  const v1::RobotSettingsList alpha = Get("missions/lab/agents/alpha");
  ASSERT_THAT(alpha.settings(), SizeIs(2));
  EXPECT_EQ(alpha.settings(0).settings(), Make(1).settings());
  EXPECT_EQ(alpha.settings(1).settings(), Make(7, "alpha").settings());
  EXPECT_EQ(alpha.settings(1).signature(), std::string(64, 's'));
  EXPECT_THAT(Get("missions/lab/agents/bravo").settings(), SizeIs(1));
  EXPECT_THAT(Get("missions/lab").settings(), SizeIs(1));
}

TEST_F(RobotSettingsServiceTest, RefusesWhatIsOlderOrOfOthers) {
  ASSERT_TRUE(Set("missions/lab/agents/alpha", Make(7, "alpha")).ok());
  for (const uint64_t version : {6, 7}) {
    ExpectRefused(Set("missions/lab/agents/alpha", Make(version, "alpha")),
                  grpc::StatusCode::FAILED_PRECONDITION, "must be newer than version 7");
  }
  ExpectRefused(Set("missions/lab/agents/bravo", Make(8, "alpha")),
                grpc::StatusCode::INVALID_ARGUMENT, "agent \"alpha\"");
  ExpectRefused(Set("missions/lab", Make(0)), grpc::StatusCode::INVALID_ARGUMENT, "version is 0");
  ExpectRefused(Set("missions/moon", Make(1)), grpc::StatusCode::INVALID_ARGUMENT, "missions/moon");
  v1::SignedRobotSettings wrong = Make(9, "alpha");
  wrong.set_signature("short");
  ExpectRefused(Set("missions/lab/agents/alpha", wrong), grpc::StatusCode::INVALID_ARGUMENT,
                "signature of 5 bytes");
  wrong.set_settings(std::string(65'537, 'x'));
  ExpectRefused(Set("missions/lab/agents/alpha", wrong), grpc::StatusCode::INVALID_ARGUMENT,
                "65537 bytes");
  EXPECT_THAT(Get("missions/lab/agents/alpha").settings(), SizeIs(1));
}

TEST_F(RobotSettingsServiceTest, AStreamIsToldBehindTheGrantAndAtChanges) {
  ASSERT_TRUE(Set("missions/lab", Make(1)).ok());
  ToldSettings told;
  UplinkNotes listener;
  RemoteUplinkOptions options;
  options.on_settings = [&told](const auto& list) { told.Add(list); };
  const auto uplink = MakeRemoteUplink(server_->InProcessChannel(), options);
  SessionRequest request;
  request.mission = "lab";
  request.agent = "alpha";
  uplink->Open(request, &listener);
  EXPECT_THAT(told.Await(1).settings(), SizeIs(1));
  // What is another robot's it is not told.
  ASSERT_TRUE(Set("missions/lab/agents/bravo", Make(1, "bravo")).ok());
  ASSERT_TRUE(Set("missions/lab/agents/alpha", Make(1, "alpha")).ok());
  const v1::RobotSettingsList both = told.Await(2);
  ASSERT_THAT(both.settings(), SizeIs(2));
  EXPECT_EQ(both.settings(1).settings(), Make(1, "alpha").settings());
  uplink->Close();
}

TEST_F(RobotSettingsServiceTest, AChangeOfAnOldMissionIsAborted) {
  v1::UpdateMissionRequest request;
  request.mutable_mission()->set_name("missions/lab");
  request.mutable_mission()->set_description("mine");
  request.mutable_update_mask()->add_paths("description");
  request.set_expected_revision(0);
  v1::Mission changed;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(stub_->UpdateMission(&context, request, &changed).ok());
    EXPECT_EQ(changed.settings_revision(), 1u);
  }
  request.mutable_mission()->set_description("theirs");
  {
    grpc::ClientContext context;
    ExpectRefused(stub_->UpdateMission(&context, request, &changed), grpc::StatusCode::ABORTED,
                  "settings_revision 1");
  }
  EXPECT_EQ(store_.GetMission("lab")->profile.description, "mine");
  request.clear_expected_revision();
  grpc::ClientContext context;
  EXPECT_TRUE(stub_->UpdateMission(&context, request, &changed).ok());
}

}  // namespace
}  // namespace corbslam::services
