// Tests the servers behind real TLS on loopback: who gets in, and how far.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/fusion_worker_service.grpc.pb.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/health_client.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/status.h"
#include "services/convert/testing/test_data.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/security_options.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using test_data::TestCertificates;
using ::testing::Contains;
using ::testing::ElementsAre;

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A worker that fails if it is asked to work: no test gets as far.
class IdleWorker : public FusionWorker {
 public:
  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest&,
                                                    const ProgressCallback&) override {
    return absl::InternalError("asked to verify");
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest&,
                                          const ProgressCallback&) override {
    return absl::InternalError("asked to fuse");
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest&,
                                                  const ProgressCallback&) override {
    return absl::InternalError("asked to adjust");
  }
};

class SecureServiceTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    certificates_ = new TestCertificates("lab");
    others_ = new TestCertificates("lab");
    vocabulary_ = new std::shared_ptr<const Vocabulary>(*Vocabulary::Load(DefaultVocabularyPath()));
  }
  static void TearDownTestSuite() {
    delete vocabulary_;
    delete others_;
    delete certificates_;
  }

  void SetUp() override {
    store_ = std::make_unique<MapStore>(MapStoreOptions(), *vocabulary_,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    SecurityOptions options = certificates_->Options("store");
    options.token_key_file = certificates_->Path("token.pub");
    Serve(options);
  }

  void Serve(const SecurityOptions& options) {
    server_.reset();
    const auto security = MakeServerSecurity(options);
    ASSERT_TRUE(security.ok()) << security.status();
    MapStoreServiceOptions service_options;
    service_options.door = security->access;
    service_ = std::make_unique<MapStoreService>(store_.get(), service_options);
    worker_service_ = std::make_unique<FusionWorkerService>(&worker_);
    auto server =
        Server::Start("127.0.0.1:0", {service_.get(), worker_service_.get()}, security->server);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  void TearDown() override { server_.reset(); }

  std::shared_ptr<grpc::Channel> Connect(const SecurityOptions& options) {
    const auto credentials = MakeChannelCredentials(options);
    EXPECT_TRUE(credentials.ok()) << credentials.status();
    return credentials.ok() ? MakeChannel(server_->address(), *credentials) : nullptr;
  }
  std::shared_ptr<grpc::Channel> ConnectAs(const std::string& name) {
    return Connect(certificates_->Options(name));
  }
  // Returns the options of a caller that trusts the server, and has no identity.
  static SecurityOptions Stranger() {
    SecurityOptions options;
    options.ca_file = certificates_->Path("ca.pem");
    return options;
  }
  static SecurityOptions WithToken(const std::string& grant, absl::Duration lifetime) {
    const auto token = SignToken({{*ParseGrant(grant)}, absl::Now() + lifetime},
                                 ReadFile(certificates_->Path("token.key")));
    EXPECT_TRUE(token.ok()) << token.status();
    SecurityOptions options = Stranger();
    options.token_file = certificates_->Path("token.txt");
    std::ofstream(options.token_file) << token.value_or("") << "\n";
    return options;
  }

  static absl::Status GetMission(const std::shared_ptr<grpc::Channel>& channel,
                                 const std::string& mission = "lab") {
    grpc::ClientContext context;
    v1::GetMissionRequest request;
    request.set_name(absl::StrCat("missions/", mission));
    v1::Mission response;
    return FromGrpcStatus(v1::MapStore::NewStub(channel)->GetMission(&context, request, &response));
  }
  static absl::Status DeleteMission(const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::DeleteMissionRequest request;
    request.set_name("missions/lab");
    v1::DeleteMissionResponse response;
    return FromGrpcStatus(
        v1::MapStore::NewStub(channel)->DeleteMission(&context, request, &response));
  }
  static absl::Status CreateMission(const std::shared_ptr<grpc::Channel>& channel,
                                    const std::string& mission) {
    grpc::ClientContext context;
    v1::CreateMissionRequest request;
    request.mutable_mission()->set_name(absl::StrCat("missions/", mission));
    v1::Mission response;
    return FromGrpcStatus(
        v1::MapStore::NewStub(channel)->CreateMission(&context, request, &response));
  }
  static absl::Status UpdateMission(const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::UpdateMissionRequest request;
    request.mutable_mission()->set_name("missions/lab");
    request.mutable_update_mask()->add_paths("description");
    v1::Mission response;
    return FromGrpcStatus(
        v1::MapStore::NewStub(channel)->UpdateMission(&context, request, &response));
  }
  // Opens a session of the agent that sends one batch, and returns how it ends: OK when the batch
  // is acknowledged.
  static absl::Status Upload(const std::shared_ptr<grpc::Channel>& channel,
                             const std::string& mission, const std::string& agent) {
    std::mt19937 random(7);
    UplinkNotes notes;
    const auto uplink = MakeRemoteUplink(channel);
    uplink->Open({.mission = mission, .agent = agent, .last_revision = 0, .local_maps = {}},
                 &notes);
    if (!notes.WaitForGrant()) return notes.WaitForClose();
    EXPECT_TRUE(uplink->Send(test_data::MakeBatch(random, test_data::kMap, 1)));
    EXPECT_EQ(notes.WaitForAcknowledgements(1), 1u);
    uplink->Close();
    return absl::OkStatus();
  }

  static TestCertificates* certificates_;
  static TestCertificates* others_;  // Certificates of another authority.
  static std::shared_ptr<const Vocabulary>* vocabulary_;

  IdleWorker worker_;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<FusionWorkerService> worker_service_;
  std::unique_ptr<Server> server_;
};
TestCertificates* SecureServiceTest::certificates_ = nullptr;
TestCertificates* SecureServiceTest::others_ = nullptr;
std::shared_ptr<const Vocabulary>* SecureServiceTest::vocabulary_ = nullptr;

MATCHER_P2(IsStatus, code, text, "") {
  *result_listener << arg.ToString();
  return arg.code() == code && absl::StrContains(arg.message(), text);
}
constexpr auto kDenied = absl::StatusCode::kPermissionDenied;
constexpr auto kNobody = absl::StatusCode::kUnauthenticated;
constexpr auto kUnavailable = absl::StatusCode::kUnavailable;

TEST_F(SecureServiceTest, AnAgentUploadsAndLooksUpInItsMission) {
  const auto alpha = ConnectAs("alpha");
  EXPECT_TRUE(Upload(alpha, "lab", "alpha").ok());
  EXPECT_TRUE(GetMission(alpha).ok());
  EXPECT_TRUE(GetMission(ConnectAs("viewer")).ok());
}

TEST_F(SecureServiceTest, AnAgentIsNobodyElseAndNowhereElse) {
  const auto alpha = ConnectAs("alpha");
  EXPECT_THAT(
      Upload(alpha, "lab", "bravo"),
      IsStatus(kDenied, "missions/lab/agents/alpha may not upload to missions/lab as agent bravo"));
  EXPECT_THAT(Upload(alpha, "field", "alpha"),
              IsStatus(kDenied, "may not upload to missions/field"));
  EXPECT_THAT(GetMission(alpha, "field"), IsStatus(kDenied, "may not look into missions/field"));
  EXPECT_EQ(store_->GetMission("field").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->GetMission("lab").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(SecureServiceTest, OnlyAnOperatorDeletes) {
  ASSERT_TRUE(Upload(ConnectAs("alpha"), "lab", "alpha").ok());
  for (const char* name : {"viewer", "alpha", "store"}) {
    EXPECT_THAT(DeleteMission(ConnectAs(name)), IsStatus(kDenied, "may not administer")) << name;
  }
  EXPECT_THAT(Upload(ConnectAs("operator"), "lab", "operator"),
              IsStatus(kDenied, "may not upload"));
  EXPECT_TRUE(GetMission(ConnectAs("viewer")).ok());
  EXPECT_TRUE(DeleteMission(ConnectAs("operator")).ok());
  EXPECT_EQ(GetMission(ConnectAs("viewer")).code(), absl::StatusCode::kNotFound);
}

TEST_F(SecureServiceTest, OnlyAnOperatorDeletesSessions) {
  ASSERT_TRUE(Upload(ConnectAs("alpha"), "lab", "alpha").ok());
  const auto forget = [](const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::ForgetLocalMapsRequest request;
    request.set_parent("missions/lab/agents/alpha");
    request.set_keep(0);
    v1::ForgetLocalMapsResponse response;
    return FromGrpcStatus(
        v1::MapStore::NewStub(channel)->ForgetLocalMaps(&context, request, &response));
  };
  for (const char* name : {"viewer", "alpha", "store"}) {
    EXPECT_THAT(forget(ConnectAs(name)), IsStatus(kDenied, "may not administer")) << name;
  }
  const auto of_field = Connect(WithToken("missions/field/operators/olga", absl::Hours(1)));
  EXPECT_THAT(forget(of_field), IsStatus(kDenied, "may not administer"));
  EXPECT_TRUE(forget(ConnectAs("operator")).ok());
}

TEST_F(SecureServiceTest, OnlyAnOperatorMakesAndChangesMissions) {
  for (const char* name : {"viewer", "alpha", "store"}) {
    EXPECT_THAT(CreateMission(ConnectAs(name), "lab"), IsStatus(kDenied, "may not administer"));
    EXPECT_THAT(UpdateMission(ConnectAs(name)), IsStatus(kDenied, "may not administer"));
  }
  EXPECT_EQ(store_->GetMission("lab").status().code(), absl::StatusCode::kNotFound);
  const auto of_lab = Connect(WithToken("missions/lab/operators/olga", absl::Hours(1)));
  EXPECT_THAT(CreateMission(of_lab, "field"), IsStatus(kDenied, "may not administer"));
  EXPECT_TRUE(CreateMission(of_lab, "lab").ok());
  EXPECT_TRUE(UpdateMission(of_lab).ok());
  EXPECT_TRUE(CreateMission(ConnectAs("operator"), "field").ok());
}

TEST_F(SecureServiceTest, WhoShowsNothingIsTurnedAway) {
  const auto stranger = Connect(Stranger());
  EXPECT_THAT(GetMission(stranger), IsStatus(kNobody, "neither a certificate"));
  EXPECT_THAT(Upload(stranger, "lab", "alpha"), IsStatus(kNobody, "neither a certificate"));
  const auto services = GenericClient(stranger).ListServices();
  EXPECT_EQ(services.status().code(), kNobody);
}

TEST_F(SecureServiceTest, ACertificateOfAnotherAuthorityDoesNotConnect) {
  SecurityOptions intruder = others_->Options("operator");
  intruder.ca_file = certificates_->Path("ca.pem");
  EXPECT_EQ(GetMission(Connect(intruder)).code(), kUnavailable);
  EXPECT_EQ(Upload(Connect(intruder), "lab", "alpha").code(), kUnavailable);
}

TEST_F(SecureServiceTest, AServerOfAnotherAuthorityIsNotTrusted) {
  SecurityOptions careful = certificates_->Options("alpha");
  careful.ca_file = others_->Path("ca.pem");
  EXPECT_EQ(Upload(Connect(careful), "lab", "alpha").code(), kUnavailable);
}

TEST_F(SecureServiceTest, WithoutTlsNobodyConnects) {
  SecurityOptions options;
  options.insecure = true;
  EXPECT_EQ(GetMission(Connect(options)).code(), kUnavailable);
}

// The viewer holds a certificate of the right authority, but not for servers.
TEST_F(SecureServiceTest, AViewerCannotPretendToBeTheServer) {
  SecurityOptions options = certificates_->Options("viewer");
  Serve(options);
  EXPECT_EQ(GetMission(ConnectAs("alpha")).code(), kUnavailable);
}

TEST_F(SecureServiceTest, ATokenIsAsGoodAsACertificateUntilItExpires) {
  const absl::Duration hour = absl::Hours(1);
  EXPECT_TRUE(Upload(Connect(WithToken("missions/lab/agents/alpha", hour)), "lab", "alpha").ok());
  EXPECT_THAT(DeleteMission(Connect(WithToken("missions/lab/viewers/eve", hour))),
              IsStatus(kDenied, "missions/lab/viewers/eve may not administer"));
  const auto late = Connect(WithToken("missions/lab/agents/alpha", -hour));
  EXPECT_THAT(GetMission(late), IsStatus(kNobody, "expired at"));
  EXPECT_THAT(Upload(late, "lab", "alpha"), IsStatus(kNobody, "expired at"));
}

TEST_F(SecureServiceTest, ATokenThatIsReplacedCountsFromTheNextCallOn) {
  const auto channel = Connect(WithToken("missions/lab/agents/alpha", -absl::Hours(1)));
  EXPECT_EQ(GetMission(channel).code(), kNobody);
  WithToken("missions/lab/agents/alpha", absl::Hours(1));
  EXPECT_EQ(GetMission(channel).code(), absl::StatusCode::kNotFound);
}

// Returns how a stream of the mission's events ends that is cancelled after the first one.
absl::Status WatchEvents(const std::shared_ptr<grpc::Channel>& channel) {
  const auto stub = v1::MapStore::NewStub(channel);
  grpc::ClientContext context;
  v1::WatchEventsRequest request;
  request.set_mission("missions/lab");
  const auto stream = stub->WatchEvents(&context, request);
  v1::MissionEvent event;
  if (stream->Read(&event)) context.TryCancel();
  return FromGrpcStatus(stream->Finish());
}

absl::Status ReplayMap(const std::shared_ptr<grpc::Channel>& channel) {
  const auto stub = v1::MapStore::NewStub(channel);
  grpc::ClientContext context;
  v1::ReplayMapRequest request;
  request.set_mission("missions/lab");
  const auto stream = stub->ReplayMap(&context, request);
  v1::WatchMapResponse changes;
  while (stream->Read(&changes)) {
  }
  return FromGrpcStatus(stream->Finish());
}

TEST_F(SecureServiceTest, WhoMayLookIsToldEventsAndThePast) {
  ASSERT_TRUE(Upload(ConnectAs("alpha"), "lab", "alpha").ok());
  for (const char* name : {"viewer", "alpha", "operator"}) {
    EXPECT_EQ(WatchEvents(ConnectAs(name)).code(), absl::StatusCode::kCancelled) << name;
    EXPECT_EQ(ReplayMap(ConnectAs(name)), absl::OkStatus()) << name;
  }
  const auto stranger = Connect(WithToken("missions/field/agents/alpha", absl::Hours(1)));
  EXPECT_THAT(WatchEvents(stranger), IsStatus(kDenied, "may not look into missions/lab"));
  EXPECT_THAT(ReplayMap(stranger), IsStatus(kDenied, "may not look into missions/lab"));
}

// Each method that names a mission refuses a caller of another mission.
TEST_F(SecureServiceTest, NoMethodForgetsTheMission) {
  ASSERT_TRUE(Upload(ConnectAs("alpha"), "lab", "alpha").ok());
  GenericClient outsider(Connect(WithToken("missions/field/operators/olga", absl::Hours(1))));
  const google::protobuf::ServiceDescriptor* service =
      v1::SyncRequest::descriptor()->file()->service(0);
  for (int i = 0; i < service->method_count(); ++i) {
    const google::protobuf::MethodDescriptor* method = service->method(i);
    // It names no mission, and leaves out those that the caller may not look into.
    if (method->name() == "ListMissions") continue;
    std::string request = "{}";
    for (const char* name : {"name", "parent", "mission", "backup"}) {
      const google::protobuf::FieldDescriptor* field = method->input_type()->FindFieldByName(name);
      if (field == nullptr) continue;
      request = field->message_type() != nullptr
                    ? absl::StrCat("{\"", name, "\": {\"name\": \"missions/lab\"}}")
                    : absl::StrCat("{\"", name, "\": \"missions/lab\"}");
    }
    if (method->name() == "Sync")
      request = R"({"open": {"mission": "missions/lab", "agent": "o"}})";
    const auto answers =
        outsider.Call(absl::StrCat(service->full_name(), "/", method->name()), request);
    EXPECT_THAT(answers.status(), IsStatus(kDenied, "missions/field/operators/olga may not"))
        << method->name();
  }
}

// The worker's certificate is for serving only.
TEST_F(SecureServiceTest, AWorkerCallsNobody) {
  EXPECT_EQ(GetMission(ConnectAs("worker")).code(), kUnavailable);
}

TEST_F(SecureServiceTest, OnlyStoresHaveWorkersCompute) {
  const auto ask = [](const std::shared_ptr<grpc::Channel>& channel) {
    const auto stub = v1::FusionWorker::NewStub(channel);
    grpc::ClientContext context;
    const auto stream = stub->FuseMaps(&context);
    stream->WritesDone();
    return FromGrpcStatus(stream->Finish());
  };
  EXPECT_THAT(ask(ConnectAs("store")),
              IsStatus(absl::StatusCode::kInvalidArgument, "ended before its end"));
  for (const char* name : {"alpha", "viewer", "operator"}) {
    EXPECT_THAT(ask(ConnectAs(name)), IsStatus(kDenied, "may not have a fusion worker compute"));
  }
}

TEST_F(SecureServiceTest, OpenHealthAnswersStrangers) {
  EXPECT_EQ(CheckHealth(Connect(Stranger()), kLiveness), absl::OkStatus());
}

TEST_F(SecureServiceTest, ClosedHealthDoesNot) {
  SecurityOptions options = certificates_->Options("store");
  options.health_is_open = false;
  Serve(options);
  // A stranger could ask nothing any more, so that it gets no handshake either.
  EXPECT_EQ(CheckHealth(Connect(Stranger()), kLiveness).code(), kUnavailable);
  EXPECT_EQ(CheckHealth(ConnectAs("viewer"), kLiveness), absl::OkStatus());
  options.token_key_file = certificates_->Path("token.pub");
  Serve(options);
  EXPECT_EQ(CheckHealth(Connect(Stranger()), kLiveness).code(), kNobody);
}

TEST_F(SecureServiceTest, ReflectionCanBeSwitchedOff) {
  EXPECT_THAT(*GenericClient(ConnectAs("viewer")).ListServices(), Contains("corbslam.v1.MapStore"));
  SecurityOptions options = certificates_->Options("store");
  options.reflection = false;
  Serve(options);
  EXPECT_EQ(GenericClient(ConnectAs("viewer")).ListServices().status().code(),
            absl::StatusCode::kUnimplemented);
  EXPECT_EQ(GetMission(ConnectAs("viewer")).code(), absl::StatusCode::kNotFound);
}

// Returns the lines of the audit log with this event.
std::vector<nlohmann::json> LinesOf(const std::string& path, const std::string& event) {
  std::ifstream file(path);
  std::vector<nlohmann::json> lines;
  for (std::string line; std::getline(file, line);) {
    const nlohmann::json json = nlohmann::json::parse(line);
    if (json["event"] == event) lines.push_back(json);
  }
  return lines;
}

TEST_F(SecureServiceTest, TheAuditLogSaysWhoDidWhat) {
  SecurityOptions options = certificates_->Options("store");
  options.token_key_file = certificates_->Path("token.pub");
  options.audit_file = certificates_->Path("audit.log");
  Serve(options);
  ASSERT_TRUE(Upload(ConnectAs("alpha"), "lab", "alpha").ok());
  EXPECT_FALSE(Upload(ConnectAs("alpha"), "field", "alpha").ok());
  EXPECT_FALSE(GetMission(ConnectAs("alpha"), "field").ok());
  EXPECT_FALSE(GetMission(Connect(Stranger())).ok());
  EXPECT_FALSE(DeleteMission(ConnectAs("viewer")).ok());
  EXPECT_TRUE(DeleteMission(ConnectAs("operator")).ok());
  EXPECT_TRUE(CreateMission(ConnectAs("operator"), "lab").ok());
  EXPECT_TRUE(UpdateMission(ConnectAs("operator")).ok());
  server_.reset();

  const auto asked = LinesOf(options.audit_file, "session_asked");
  ASSERT_EQ(asked.size(), 2u);
  EXPECT_EQ(asked[0]["identity"], "missions/lab/agents/alpha");
  EXPECT_EQ(asked[0]["resource"], "missions/lab/agents/alpha");
  EXPECT_TRUE(absl::StartsWith(asked[0]["peer"].get<std::string>(), "ipv4:127.0.0.1:"));
  EXPECT_EQ(LinesOf(options.audit_file, "session_ended").size(), 1u);
  const auto administered = LinesOf(options.audit_file, "administered");
  ASSERT_EQ(administered.size(), 3u);
  EXPECT_EQ(administered[1]["call"], "corbslam.v1.MapStore/CreateMission");
  EXPECT_EQ(administered[1]["resource"], "missions/lab");
  EXPECT_EQ(administered[2]["call"], "corbslam.v1.MapStore/UpdateMission");
  EXPECT_EQ(administered[2]["resource"], "missions/lab");
  EXPECT_EQ(administered[0]["identity"], "missions/-/operators/operator");
  EXPECT_EQ(administered[0]["call"], "corbslam.v1.MapStore/DeleteMission");
  EXPECT_EQ(administered[0]["resource"], "missions/lab");
  EXPECT_EQ(administered[0]["code"], "OK");
  const auto refused = LinesOf(options.audit_file, "refused");
  ASSERT_EQ(refused.size(), 4u);
  EXPECT_EQ(refused[0]["resource"], "missions/field/agents/alpha");
  EXPECT_EQ(refused[0]["code"], "PERMISSION_DENIED");
  EXPECT_EQ(refused[1]["resource"], "missions/field");
  EXPECT_EQ(refused[2]["code"], "UNAUTHENTICATED");
  EXPECT_FALSE(refused[2].contains("identity"));
  EXPECT_EQ(refused[3]["identity"], "missions/lab/viewers/viewer");
}

// Returns the names in all pages of one mission each.
std::vector<std::string> ListMissions(const std::shared_ptr<grpc::Channel>& channel) {
  std::vector<std::string> names;
  v1::ListMissionsRequest request;
  request.set_page_size(1);
  do {
    grpc::ClientContext context;
    v1::ListMissionsResponse response;
    const absl::Status status =
        FromGrpcStatus(v1::MapStore::NewStub(channel)->ListMissions(&context, request, &response));
    EXPECT_TRUE(status.ok()) << status;
    for (const v1::Mission& mission : response.missions()) names.push_back(mission.name());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return names;
}

TEST_F(SecureServiceTest, AListShowsTheMissionsThatItsCallerMayLookInto) {
  for (const char* mission : {"attic", "field", "lab", "yard"}) {
    const std::string grant = absl::StrCat("missions/", mission, "/agents/alpha");
    EXPECT_TRUE(Upload(Connect(WithToken(grant, absl::Hours(1))), mission, "alpha").ok());
  }
  EXPECT_THAT(ListMissions(ConnectAs("operator")),
              ElementsAre("missions/attic", "missions/field", "missions/lab", "missions/yard"));
  EXPECT_THAT(ListMissions(ConnectAs("viewer")), ElementsAre("missions/lab"));
  EXPECT_THAT(ListMissions(Connect(WithToken("missions/cellar/viewers/eve", absl::Hours(1)))),
              ElementsAre());
}

}  // namespace
}  // namespace corbslam::services
