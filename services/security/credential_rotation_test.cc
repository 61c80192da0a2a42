// Tests, with TLS on loopback, that credentials are replaced and revoked while robots stream.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/status.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/credential_watch.h"
#include "services/security/security_options.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

namespace fs = std::filesystem;

using test_data::TestCertificates;
using ::testing::HasSubstr;

constexpr absl::Duration kPatience = absl::Seconds(20);

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Replaces a file as careful people do.
void Replace(const std::string& path, const std::string& text) {
  std::ofstream(path + ".new") << text;
  fs::rename(path + ".new", path);
}

bool ComesTrue(const std::function<bool()>& condition) {
  const absl::Time deadline = absl::Now() + kPatience;
  while (!condition()) {
    if (absl::Now() > deadline) return false;
    absl::SleepFor(absl::Milliseconds(100));
  }
  return true;
}

CredentialState StateOf(Credential credential) {
  return CredentialStates()[static_cast<size_t>(credential)];
}

// A robot's session, and what it was told.
struct Session {
  UplinkNotes notes;
  std::unique_ptr<Uplink> uplink;
  LocalMapId local_map;
};

class CredentialRotationTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    vocabulary_ = new std::shared_ptr<const Vocabulary>(*Vocabulary::Load(DefaultVocabularyPath()));
  }
  static void TearDownTestSuite() { delete vocabulary_; }

  void SetUp() override {
    Replace(ours_.Path("revoked"), "");
    SecurityOptions options = ours_.Options("store");
    options.token_key_file = ours_.Path("token.pub");
    options.revoked_file = ours_.Path("revoked");
    const auto security = MakeServerSecurity(options);
    ASSERT_TRUE(security.ok()) << security.status();
    MapStoreServiceOptions service_options;
    service_options.door = security->access;
    service_ = std::make_unique<MapStoreService>(&store_, service_options);
    auto server = Server::Start("127.0.0.1:0", {service_.get()}, security->server);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  void TearDown() override { server_.reset(); }

  std::shared_ptr<grpc::Channel> Connect(const SecurityOptions& options) {
    const auto credentials = MakeChannelCredentials(options);
    EXPECT_TRUE(credentials.ok()) << credentials.status();
    return credentials.ok() ? MakeChannel(server_->address(), *credentials) : nullptr;
  }
  // Returns the options of a caller who shows a token beside alpha's certificate.
  SecurityOptions WithToken(const std::string& grant, const std::string& id) {
    const auto token = SignToken({{*ParseGrant(grant)}, absl::Now() + absl::Hours(1), id},
                                 TextOf(ours_.Path("token.key")));
    EXPECT_TRUE(token.ok()) << token.status();
    SecurityOptions options = ours_.Options("alpha");
    options.token_file = ours_.Path(absl::StrCat(id, ".token"));
    Replace(options.token_file, token.value_or(""));
    return options;
  }
  static absl::Status GetMission(const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::GetMissionRequest request;
    request.set_name("missions/lab");
    v1::Mission response;
    return FromGrpcStatus(v1::MapStore::NewStub(channel)->GetMission(&context, request, &response));
  }
  // Returns true if the server lets this caller in and knows it, with a connection of its own.
  bool IsLetIn(const SecurityOptions& options) {
    const absl::StatusCode code = GetMission(Connect(options)).code();
    return code == absl::StatusCode::kOk || code == absl::StatusCode::kNotFound;
  }

  // Opens a session over a connection of its own; it shows the token `id`.
  std::unique_ptr<Session> Open(const std::string& agent, const std::string& id) {
    auto session = std::make_unique<Session>();
    session->local_map = {0xc0ffee00 + next_local_map_++};
    session->uplink =
        MakeRemoteUplink(Connect(WithToken(absl::StrCat("missions/lab/agents/", agent), id)));
    session->uplink->Open({.mission = "lab", .agent = agent, .last_revision = 0, .local_maps = {}},
                          &session->notes);
    EXPECT_TRUE(session->notes.WaitForGrant().has_value()) << session->notes.WaitForClose();
    return session;
  }
  // Sends the session's batch of this number, and expects it to be acknowledged.
  static void Send(Session& session, uint64_t number) {
    std::mt19937 random(7);
    MapUpdateBatch batch;
    batch.number = number;
    batch.local_map = session.local_map;
    if (number == 1) batch = test_data::MakeBatch(random, session.local_map, number);
    EXPECT_TRUE(session.uplink->Send(batch));
    EXPECT_EQ(session.notes.WaitForAcknowledgements(number), number);
  }

  static std::shared_ptr<const Vocabulary>* vocabulary_;

  TestCertificates ours_{"lab"};
  TestCertificates others_{"lab"};  // Of another authority.
  uint64_t next_local_map_ = 1;
  MapStore store_{MapStoreOptions(), *vocabulary_, std::make_unique<InMemoryJournal>(), nullptr};
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
};
std::shared_ptr<const Vocabulary>* CredentialRotationTest::vocabulary_ = nullptr;

// A whole change of authority, in the order of docs/security.md.
TEST_F(CredentialRotationTest, EightRobotsStreamOnWhileEverythingIsReplaced) {
  std::vector<std::unique_ptr<Session>> sessions;
  for (int i = 0; i < 8; ++i) {
    sessions.push_back(Open(absl::StrCat("robot", i), absl::StrCat("token-", i)));
    Send(*sessions.back(), 1);
  }
  SecurityOptions other_viewer = others_.Options("viewer");
  other_viewer.ca_file = ours_.Path("ca.pem");
  EXPECT_FALSE(IsLetIn(other_viewer));

  // The server trusts both authorities.
  const std::string other_authority = TextOf(others_.Path("ca.pem"));
  Replace(ours_.Path("ca.pem"), absl::StrCat(TextOf(ours_.Path("ca.pem")), other_authority));
  EXPECT_TRUE(ComesTrue([&] { return IsLetIn(other_viewer); }));
  for (const auto& session : sessions) Send(*session, 2);

  // It shows another certificate; its key comes a moment later.
  Replace(ours_.Path("store.pem"), TextOf(others_.Path("store.pem")));
  Replace(ours_.Path("store.key"), TextOf(others_.Path("store.key")));
  EXPECT_TRUE(ComesTrue([&] { return IsLetIn(others_.Options("viewer")); }));
  for (const auto& session : sessions) Send(*session, 3);

  // It trusts the other authority alone, and other keys of tokens.
  Replace(ours_.Path("ca.pem"), other_authority);
  Replace(ours_.Path("token.pub"), TextOf(others_.Path("token.pub")));
  SecurityOptions our_viewer = ours_.Options("viewer");
  EXPECT_TRUE(ComesTrue([&] { return !IsLetIn(our_viewer); }));
  for (const auto& session : sessions) Send(*session, 4);
  for (const auto& session : sessions) EXPECT_FALSE(session->notes.IsClosed());
}

// A client that is waiting for a server, say, shows the certificate that is there when it connects.
TEST_F(CredentialRotationTest, AClientShowsItsNewCertificate) {
  const auto channel = Connect(ours_.Options("viewer"));
  Replace(ours_.Path("viewer.pem"), TextOf(ours_.Path("worker.pem")));
  Replace(ours_.Path("viewer.key"), TextOf(ours_.Path("worker.key")));
  EXPECT_TRUE(ComesTrue([] { return StateOf(Credential::kCertificate).taken > 0; }));
  // gRPC looks once a second.
  absl::SleepFor(absl::Milliseconds(2500));
  // A worker's certificate is for serving only.
  EXPECT_EQ(GetMission(channel).code(), absl::StatusCode::kUnavailable);
}

TEST_F(CredentialRotationTest, WhatCannotBeUsedIsRefusedAndTheOldStays) {
  Replace(ours_.Path("store.key"), TextOf(ours_.Path("worker.key")));
  Replace(ours_.Path("ca.pem.junk"), "junk");
  EXPECT_TRUE(ComesTrue([] { return StateOf(Credential::kCertificate).refused; }));
  EXPECT_FALSE(StateOf(Credential::kAuthorities).refused);
  EXPECT_TRUE(IsLetIn(ours_.Options("viewer")));
  Replace(ours_.Path("store.pem"), TextOf(ours_.Path("worker.pem")));
  EXPECT_TRUE(ComesTrue([] { return !StateOf(Credential::kCertificate).refused; }));
}

TEST_F(CredentialRotationTest, ARevokedTokensStreamEndsAndSaysWhy) {
  const auto alpha = Open("alpha", "token-a");
  const auto bravo = Open("bravo", "token-b");
  const auto carol = Open("carol", "token-c");
  Replace(ours_.Path("revoked"), "token-a  # stolen\nmissions/lab/agents/bravo\n");
  const absl::Status end = alpha->notes.WaitForClose();
  EXPECT_EQ(end.code(), absl::StatusCode::kUnauthenticated) << end;
  EXPECT_THAT(std::string(end.message()), HasSubstr("token-a"));
  EXPECT_THAT(std::string(bravo->notes.WaitForClose().message()),
              HasSubstr("missions/lab/agents/bravo is revoked"));
  Send(*carol, 1);
  EXPECT_FALSE(carol->notes.IsClosed());
  // Nor does it get in again, by another connection.
  EXPECT_EQ(GetMission(Connect(WithToken("missions/lab/viewers/eve", "token-a"))).code(),
            absl::StatusCode::kUnauthenticated);
  EXPECT_TRUE(IsLetIn(WithToken("missions/lab/viewers/eve", "token-e")));
}

TEST_F(CredentialRotationTest, ARevokedCallersWatchEnds) {
  const auto carol = Open("carol", "token-c");
  const auto stub =
      v1::MapStore::NewStub(Connect(WithToken("missions/lab/viewers/eve", "token-e")));
  grpc::ClientContext context;
  v1::WatchEventsRequest request;
  request.set_mission("missions/lab");
  const auto stream = stub->WatchEvents(&context, request);
  v1::MissionEvent event;
  ASSERT_TRUE(stream->Read(&event));
  Replace(ours_.Path("revoked"), "token-e\n");
  while (stream->Read(&event)) {
  }
  const absl::Status end = FromGrpcStatus(stream->Finish());
  EXPECT_EQ(end.code(), absl::StatusCode::kUnauthenticated) << end;
  EXPECT_THAT(std::string(end.message()), HasSubstr("token-e"));
}

TEST_F(CredentialRotationTest, AListThatCannotBeReadRevokesNobody) {
  const auto alpha = Open("alpha", "token-a");
  Replace(ours_.Path("revoked"), "token-a\nmissions/lab/robots/bravo\n");
  EXPECT_TRUE(ComesTrue([] { return StateOf(Credential::kRevokedTokens).refused; }));
  Send(*alpha, 1);
  EXPECT_FALSE(alpha->notes.IsClosed());
}

}  // namespace
}  // namespace corbslam::services
