// Tests who may make which call: each call of our services, made by each kind of caller.
#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "corbslam/v1/agent_service.grpc.pb.h"
#include "corbslam/v1/fusion_worker_service.grpc.pb.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/convert/status.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/security_options.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using test_data::TestCertificates;

// The callers by a letter each; nobody has no identity.
constexpr char kNoIdentity = 'n';
const std::map<char, std::string>& Grants() {
  static const auto& grants =
      *new std::map<char, std::string>{{kNoIdentity, ""},
                                       {'a', "missions/lab/agents/alpha"},
                                       {'b', "missions/lab/agents/bravo"},
                                       {'e', "missions/field/viewers/eve"},
                                       {'f', "missions/field/agents/alpha"},
                                       {'g', "missions/-/operators/greta"},
                                       {'o', "missions/field/operators/olga"},
                                       {'p', "missions/lab/operators/paul"},
                                       {'s', "stores/main"},
                                       {'v', "missions/lab/viewers/vera"},
                                       {'w', "workers/one"}};
  return grants;
}

// Everybody who may look into missions/lab, and who may administer it.
constexpr char kMayLook[] = "abgpv";
constexpr char kOperators[] = "gp";

struct Row {
  std::string method;
  std::string request;
  std::string may;      // The callers whom it lets in.
  std::string refusal;  // What the others are told that they may not do.
};

// Nothing is there of what these ask for, so that every call ends soon; what CreateMission makes
// comes last.
const std::vector<Row>& StoreRows() {
  static const auto& rows = *new std::vector<Row>{
      {"Sync", R"({"open": {"mission": "missions/lab", "agent": "alpha", "localise_only": true}})",
       "a", "upload to "},
      {"WatchMap", R"({"mission": "missions/lab"})", kMayLook, "look into "},
      {"ReplayMap", R"({"mission": "missions/lab"})", kMayLook, "look into "},
      {"WatchEvents", R"({"mission": "missions/lab"})", kMayLook, "look into "},
      {"ListMissions", "{}", "abefgopv", "list missions"},
      {"GetMission", R"({"name": "missions/lab"})", kMayLook, "look into "},
      {"UpdateMission", R"({"mission": {"name": "missions/lab"}})", kOperators, "administer "},
      {"SetRobotSettings", R"({"name": "missions/lab/agents/alpha"})", kOperators, "administer "},
      {"GetRobotSettings", R"({"name": "missions/lab/agents/alpha"})", kMayLook, "look into "},
      {"DeleteMission", R"({"name": "missions/lab"})", kOperators, "administer "},
      {"SleepMission", R"({"name": "missions/lab"})", kOperators, "administer "},
      {"BackupMission", R"({"name": "missions/lab"})", kOperators, "administer "},
      {"RestoreMission", R"({"name": "missions/lab"})", kOperators, "administer "},
      {"StoreBackup", R"({"name": "missions/lab"})", kOperators, "administer "},
      {"ListStoredBackups", R"({"parent": "missions/lab"})", kOperators, "administer "},
      {"ListStoredBackups", R"({"parent": "missions/-"})", "gop", "administer any mission"},
      {"RestoreStoredBackup", R"({"backup": "missions/lab/backups/1"})", kOperators, "administer "},
      {"RestoreStoredBackup", R"({"backup": "missions/lab/backups/1", "name": "missions/field"})",
       "g", "administer "},
      {"RestoreStoredBackup", R"({"backup": "missions/field/backups/1", "name": "missions/lab"})",
       "g", "administer "},
      {"VerifyStoredBackup", R"({"backup": "missions/lab/backups/1"})", kOperators, "administer "},
      {"DeleteStoredBackup", R"({"backup": "missions/lab/backups/1"})", kOperators, "administer "},
      {"ArchiveMission", R"({"name": "missions/lab"})", kOperators, "administer "},
      {"ListAgents", R"({"parent": "missions/lab"})", kMayLook, "look into "},
      {"ListLocalMaps", R"({"parent": "missions/lab"})", kMayLook, "look into "},
      {"GetLocalMap", R"({"name": "missions/lab/localMaps/1"})", kMayLook, "look into "},
      {"ListKeyframes", R"({"parent": "missions/lab/localMaps/1"})", kMayLook, "look into "},
      {"GetKeyframe", R"({"name": "missions/lab/localMaps/1/keyframes/1"})", kMayLook,
       "look into "},
      {"AskForExactPlaces", R"({"name": "missions/lab/agents/alpha"})", kOperators, "administer "},
      {"GetStatistics", R"({"mission": "missions/lab"})", kMayLook, "look into "},
      {"Localize", R"({"mission": "missions/lab"})", kMayLook, "look into "},
      {"LocalizeStream", R"({"mission": "missions/lab"})", kMayLook, "look into "},
      {"GetTrajectory", R"({"name": "missions/lab/agents/-", "frame": 1})", kMayLook, "look into "},
      {"ListOverlaps", R"({"parent": "missions/lab"})", kMayLook, "look into "},
      {"GetOverlap", R"({"name": "missions/lab/overlaps/1"})", kMayLook, "look into "},
      {"RetractOverlap", R"({"name": "missions/lab/overlaps/1"})", kOperators, "administer "},
      {"ForgetLocalMaps", R"({"parent": "missions/lab/agents/alpha"})", kOperators, "administer "},
      {"RederiveGlobalLayer", R"({"name": "missions/lab"})", kOperators, "administer "},
      {"CreateMission", R"({"mission": {"name": "missions/lab"}})", kOperators, "administer "}};
  return rows;
}

const std::vector<Row>& WorkerRows() {
  static const auto& rows =
      *new std::vector<Row>{{"VerifyOverlap", "{}", "s", "have a fusion worker compute"},
                            {"FuseMaps", "{}", "s", "have a fusion worker compute"},
                            {"AdjustBundle", "{}", "s", "have a fusion worker compute"},
                            {"LocateFrame", "{}", "s", "have a fusion worker compute"},
                            {"ExtractFeatures", "{}", "s", "have a fusion worker compute"}};
  return rows;
}

// Those of agent alpha of missions/lab.
const std::vector<Row>& AgentRows() {
  static const auto& rows =
      *new std::vector<Row>{{"WatchPose", "{}", kMayLook, "look into missions/lab"},
                            {"WatchEvents", "{}", kMayLook, "look into missions/lab"},
                            {"WatchMap", "{}", kMayLook, "look into missions/lab"},
                            {"GetStatus", "{}", kMayLook, "look into missions/lab"},
                            {"GetTrajectory", "{}", kMayLook, "look into missions/lab"},
                            {"PauseMapping", "{}", "agp", "give orders to alpha of missions/lab"},
                            {"ResumeMapping", "{}", "agp", "give orders to alpha of missions/lab"},
                            {"OpenNewMap", "{}", "agp", "give orders to alpha of missions/lab"},
                            {"SetMask", "{}", "agp", "give orders to alpha of missions/lab"}};
  return rows;
}

class AccessMatrixTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { certificates_ = new TestCertificates("lab"); }
  static void TearDownTestSuite() { delete certificates_; }

  void SetUp() override {
    SecurityOptions options = certificates_->Options("store");
    options.token_key_file = certificates_->Path("token.pub");
    const auto of_store = MakeServerSecurity(options);
    const auto of_agent = MakeServerSecurity(options, "lab", "alpha");
    ASSERT_TRUE(of_store.ok() && of_agent.ok()) << of_store.status() << of_agent.status();
    store_ =
        std::make_unique<MapStore>(MapStoreOptions(), *Vocabulary::Load(DefaultVocabularyPath()),
                                   std::make_unique<InMemoryJournal>(), nullptr);
    MapStoreServiceOptions service_options;
    service_options.door = of_store->access;
    service_ = std::make_unique<MapStoreService>(store_.get(), service_options);
    auto server = Server::Start("127.0.0.1:0", {service_.get(), &worker_}, of_store->server);
    auto robot = Server::Start("127.0.0.1:0", {&agent_}, of_agent->server);
    ASSERT_TRUE(server.ok() && robot.ok()) << server.status() << robot.status();
    server_ = *std::move(server);
    robot_ = *std::move(robot);
  }
  void TearDown() override {
    robot_.reset();
    server_.reset();
  }

  static std::shared_ptr<grpc::Channel> ConnectAs(char caller, const Server& server) {
    SecurityOptions options;
    options.ca_file = certificates_->Path("ca.pem");
    if (caller != kNoIdentity) {
      std::ifstream file(certificates_->Path("token.key"));
      const std::string key{std::istreambuf_iterator<char>(file), {}};
      const auto token =
          SignToken({{*ParseGrant(Grants().at(caller))}, absl::Now() + absl::Hours(1)}, key);
      EXPECT_TRUE(token.ok()) << token.status();
      options.token_file = certificates_->Path(absl::StrCat("token_", std::string(1, caller)));
      std::ofstream(options.token_file) << token.value_or("") << "\n";
    }
    return MakeChannel(server.address(), *MakeChannelCredentials(options));
  }

  // Nobody can't ask what a call looks like, so this one sends nothing.
  static absl::Status CallAsNobody(const std::string& method, const Server& server) {
    grpc::GenericStub stub(ConnectAs(kNoIdentity, server));
    grpc::ClientContext context;
    const grpc::Slice nothing;
    const grpc::ByteBuffer request(&nothing, 1);
    grpc::ByteBuffer response;
    absl::Notification done;
    grpc::Status status;
    stub.UnaryCall(&context, method, grpc::StubOptions(), &request, &response,
                   [&](const grpc::Status& answer) {
                     status = answer;
                     done.Notify();
                   });
    done.WaitForNotification();
    return FromGrpcStatus(status);
  }

  // Makes each call as each caller.
  static void CheckRows(const google::protobuf::ServiceDescriptor* service,
                        const std::vector<Row>& rows, const Server& server) {
    std::map<char, std::unique_ptr<GenericClient>> clients;
    for (const auto& [caller, grant] : Grants()) {
      clients[caller] = std::make_unique<GenericClient>(ConnectAs(caller, server));
    }
    std::set<std::string> asked;
    for (const Row& row : rows) {
      asked.insert(row.method);
      const std::string method = absl::StrCat(service->full_name(), "/", row.method);
      for (const auto& [caller, grant] : Grants()) {
        const absl::Status status = caller == kNoIdentity
                                        ? CallAsNobody(absl::StrCat("/", method), server)
                                        : clients[caller]->Call(method, row.request).status();
        CheckAnswer(row, caller, status);
      }
    }
    for (int i = 0; i < service->method_count(); ++i) {
      EXPECT_TRUE(asked.contains(service->method(i)->name())) << service->method(i)->name();
    }
  }

  static void CheckAnswer(const Row& row, char caller, const absl::Status& status) {
    const std::string who = absl::StrCat(row.method, " ", row.request, " by ", Grants().at(caller));
    if (caller == kNoIdentity) {
      EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated) << who << ": " << status;
    } else if (absl::StrContains(row.may, caller)) {
      EXPECT_NE(status.code(), absl::StatusCode::kPermissionDenied) << who << ": " << status;
      EXPECT_NE(status.code(), absl::StatusCode::kUnauthenticated) << who << ": " << status;
      EXPECT_NE(status.code(), absl::StatusCode::kUnavailable) << who << ": " << status;
    } else {
      EXPECT_EQ(status.code(), absl::StatusCode::kPermissionDenied) << who << ": " << status;
      EXPECT_TRUE(absl::StartsWith(status.message(),
                                   absl::StrCat(Grants().at(caller), " may not ", row.refusal)))
          << who << ": " << status;
    }
  }

  static TestCertificates* certificates_;

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  v1::FusionWorker::CallbackService worker_;
  v1::Agent::CallbackService agent_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Server> robot_;
};
TestCertificates* AccessMatrixTest::certificates_ = nullptr;

TEST_F(AccessMatrixTest, OfTheMapStore) {
  CheckRows(v1::SyncRequest::descriptor()->file()->service(0), StoreRows(), *server_);
}

TEST_F(AccessMatrixTest, OfAFusionWorker) {
  CheckRows(v1::FuseMapsRequest::descriptor()->file()->service(0), WorkerRows(), *server_);
}

TEST_F(AccessMatrixTest, OfARobot) {
  CheckRows(v1::AgentStatus::descriptor()->file()->service(0), AgentRows(), *robot_);
}

// A name is looked at once it is known that the caller may make such calls at all.
TEST_F(AccessMatrixTest, ANameThatCantBeReadIsToldToThoseWhoMayAskAtAll) {
  const auto ask = [&](char caller, const std::string& method, const std::string& request) {
    return GenericClient(ConnectAs(caller, *server_))
        .Call(absl::StrCat("corbslam.v1.MapStore/", method), request)
        .status();
  };
  for (const char caller : {'e', 'g', 'v'}) {
    EXPECT_EQ(ask(caller, "GetMission", R"({"name": "lab"})"),
              absl::InvalidArgumentError("name is \"lab\", must begin with missions/{mission}"));
  }
  EXPECT_EQ(ask('s', "GetMission", R"({"name": "lab"})").code(),
            absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(ask('g', "DeleteMission", R"({"name": "missions/-"})").code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ask('g', "CreateMission", "{}").code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ask('g', "RestoreStoredBackup", R"({"name": "missions/lab"})").code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace corbslam::services
