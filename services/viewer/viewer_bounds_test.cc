// Tests what one browser, one token or one host can't take from others.
#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/http/browser_options.h"
#include "services/http/testing/raw_http.h"
#include "services/http/testing/web_client.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/security_options.h"
#include "services/security/testing/test_certificates.h"
#include "services/security/testing/token_keys.h"
#include "services/server/server.h"
#include "services/viewer/viewer.h"

namespace corbslam::services {
namespace {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using testing::Ask;
using ::testing::HasSubstr;
using testing::MakeRequest;
using testing::RawConnection;
using testing::StatusOf;
using testing::WebSocketClient;

std::string TextOfFile(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

constexpr char kStream[] = "/stream/missions/lab";

// A viewer of no store, whose tokens can be revoked.
class ViewerBoundsTest : public ::testing::Test {
 protected:
  void Start(const ViewerOptions& options = {},
             const WebServerOptions& web_options = BrowserOptions()) {
    AccessControlOptions access;
    access.tokens = *TokenVerifier::FromPem(keys_.public_pem);
    access_ = std::make_shared<AccessControl>(access);
    viewer_ = std::make_unique<Viewer>(
        grpc::CreateChannel("127.0.0.1:1", grpc::InsecureChannelCredentials()),
        MissionFeeds::Robots(), access_, PageFiles::Load("/nowhere"), options);
    auto web = WebServer::Start("127.0.0.1:0", viewer_.get(), web_options);
    ASSERT_TRUE(web.ok()) << web.status();
    web_ = *std::move(web);
  }
  void TearDown() override {
    web_.reset();
    viewer_.reset();
  }

  std::string Token(const std::string& id, absl::Duration lifetime = absl::Hours(1)) const {
    return *SignToken({{*ParseGrant("missions/lab/viewers/eve")}, absl::Now() + lifetime, id},
                      keys_.private_pem);
  }
  static testing::SocketOptions With(const std::string& token) {
    return {.protocols = absl::StrCat("corbslam, token.", token)};
  }
  std::unique_ptr<WebSocketClient> Open(const std::string& token) const {
    return std::make_unique<WebSocketClient>(web_->address(), kStream, With(token));
  }
  // Reads until the server closes it; returns for how long it stood.
  static absl::Duration ReadToEnd(WebSocketClient& client) {
    const absl::Time begin = absl::Now();
    while (client.Read().has_value()) continue;
    return absl::Now() - begin;
  }
  std::string Get(const std::string& target, const std::string& headers = "") const {
    return Ask(web_->address(), MakeRequest("GET", target, headers + "Connection: close\r\n"));
  }

  const test_data::TokenKeys keys_ = test_data::MakeTokenKeys();
  std::shared_ptr<AccessControl> access_;
  std::unique_ptr<Viewer> viewer_;
  std::unique_ptr<WebServer> web_;
};

TEST_F(ViewerBoundsTest, ATokenThatIsRevokedClosesItsPages) {
  Start();
  const auto tablet = Open(Token("tablet"));
  const auto desk = Open(Token("desk"));
  ASSERT_TRUE(tablet->stands() && tablet->Read().has_value());
  access_->SetRevoked(*RevokedList::Parse("tablet"));
  EXPECT_LT(ReadToEnd(*tablet), absl::Seconds(5));
  EXPECT_EQ(tablet->close_code(), 4401);
  EXPECT_TRUE(desk->Read().has_value());
  EXPECT_EQ(web_->streams(), 1u);
}

TEST_F(ViewerBoundsTest, SoDoesOneThatExpiresOrWhoseKeyIsTakenAway) {
  Start();
  const auto expiring = Open(Token("short", absl::Seconds(2)));
  const auto keyless = Open(Token("desk"));
  ASSERT_TRUE(expiring->Read().has_value() && keyless->Read().has_value());
  EXPECT_LT(ReadToEnd(*expiring), absl::Seconds(7));
  EXPECT_EQ(expiring->close_code(), 4401);
  access_->SetTokens(*TokenVerifier::FromPem(test_data::MakeTokenKeys().public_pem));
  EXPECT_LT(ReadToEnd(*keyless), absl::Seconds(5));
  EXPECT_EQ(keyless->close_code(), 4401);
}

TEST_F(ViewerBoundsTest, OneTokenDoesNotOpenAllPages) {
  WebServerOptions options = BrowserOptions();
  options.max_streams = 8;
  Start({}, options);
  std::vector<std::unique_ptr<WebSocketClient>> pages;
  const std::string token = Token("greedy");
  for (int i = 0; i < 8; ++i) pages.push_back(Open(token));
  EXPECT_EQ(web_->streams(), 2u) << "a quarter of them";
  for (int i = 0; i < 8; ++i) pages.push_back(Open(Token(absl::StrCat("other", i))));
  EXPECT_EQ(web_->streams(), 4u) << "one host has a half of them";
}

TEST_F(ViewerBoundsTest, WhoIsRefusedTakesNoPage) {
  WebServerOptions options = BrowserOptions();
  options.max_streams = 4;
  Start({}, options);
  std::vector<std::unique_ptr<WebSocketClient>> refused;
  // They never read that they are refused.
  for (int i = 0; i < 20; ++i) refused.push_back(Open(absl::StrCat("nonsense", i)));
  const auto page = Open(Token("desk"));
  EXPECT_TRUE(page->stands() && page->Read().has_value());
}

TEST_F(ViewerBoundsTest, WhoIsRefusedOftenWaitsAndOthersDoNot) {
  Start();
  const std::string bad = "Authorization: Bearer nonsense\r\n";
  for (int i = 0; i < 10; ++i) EXPECT_EQ(StatusOf(Get("/api/missions/lab", bad)), 401);
  absl::Time begin = absl::Now();
  EXPECT_EQ(StatusOf(Get("/api/missions/lab", bad)), 401);
  EXPECT_GE(absl::Now() - begin, absl::Milliseconds(900));
  begin = absl::Now();
  EXPECT_EQ(StatusOf(Get("/healthz")), 200);
  EXPECT_LT(absl::Now() - begin, absl::Milliseconds(900));
}

TEST_F(ViewerBoundsTest, TheProbeIsAnsweredBesideIdleConnections) {
  WebServerOptions options = BrowserOptions();
  options.connections = {.all = 40, .of_host = 20};
  Start({}, options);
  std::vector<RawConnection> idle;
  for (int i = 0; i < 60; ++i) idle.emplace_back(web_->address());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(StatusOf(Get("/healthz")), 200);
  const auto page = Open(Token("desk"));
  EXPECT_TRUE(page->stands() && page->Read().has_value());
  for (int i = 0; i < 60; ++i) idle.emplace_back(web_->address());
  EXPECT_TRUE(page->Read().has_value()) << "a page that is followed makes no room";
  // The last ones may wait to be accepted.
  for (int i = 0; i < 500 && web_->connections().closed_for_room < 80u; ++i) {
    absl::SleepFor(absl::Milliseconds(10));
  }
  EXPECT_GE(web_->connections().closed_for_room, 80u);
}

// Twenty robots that are off, one after the other, would take twenty seconds.
TEST(ViewerRobotsTest, RobotsThatAreOffAreAskedSideBySide) {
  // These are addresses that nobody has, and from which nothing comes back.
  MissionFeeds::Robots robots;
  for (int i = 0; i < 20; ++i) {
    robots["lab"].push_back(
        {absl::StrCat("robot", i), grpc::CreateChannel(absl::StrCat("192.0.2.", i + 1, ":9"),
                                                       grpc::InsecureChannelCredentials())});
  }
  Viewer viewer(grpc::CreateChannel("127.0.0.1:1", grpc::InsecureChannelCredentials()), robots,
                nullptr, PageFiles::Load("/nowhere"));
  const auto web = WebServer::Start("127.0.0.1:0", &viewer, BrowserOptions());
  ASSERT_TRUE(web.ok()) << web.status();
  const absl::Time begin = absl::Now();
  WebSocketClient page((*web)->address(), kStream);
  v1::ViewerMessage message;
  for (int pulses = 0; pulses < 2;) {
    const auto bytes = page.Read();
    ASSERT_TRUE(bytes.has_value());
    ASSERT_TRUE(message.ParseFromString(*bytes));
    pulses += message.has_pulse() ? 1 : 0;
  }
  EXPECT_EQ(message.pulse().robots_size(), 20);
  EXPECT_LT(absl::Now() - begin, absl::Seconds(10));
}

// The list that a map store has is the one that counts.
TEST(ViewerTokenWatchTest, WhomTheStoreRevokesSeesNothingHere) {
  const auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
  ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
  const test_data::TestCertificates certificates("lab");
  const std::string list = certificates.Path("revoked");
  std::ofstream(list) << "other\n";
  MapStore store(MapStoreOptions(), *vocabulary, std::make_unique<InMemoryJournal>(), nullptr);
  SecurityOptions secure = certificates.Options("store");
  secure.ca_file.clear();
  secure.token_key_file = certificates.Path("token.pub");
  secure.revoked_file = list;
  const auto security = MakeServerSecurity(secure);
  ASSERT_TRUE(security.ok()) << security.status();
  MapStoreServiceOptions guarded;
  guarded.door = security->access;
  MapStoreService service(&store, guarded);
  const auto server = Server::Start("127.0.0.1:0", {&service}, security->server);
  ASSERT_TRUE(server.ok()) << server.status();
  SecurityOptions calling;
  calling.ca_file = certificates.Path("ca.pem");
  const auto credentials = MakeChannelCredentials(calling);
  ASSERT_TRUE(credentials.ok()) << credentials.status();
  const auto token =
      SignToken({{*ParseGrant("missions/lab/viewers/eve")}, absl::Now() + absl::Hours(1), "tablet"},
                TextOfFile(certificates.Path("token.key")));
  ASSERT_TRUE(token.ok()) << token.status();
  TokenWatch watch(MakeChannel((*server)->address(), *credentials), absl::Milliseconds(20));
  EXPECT_EQ(watch.AskAndCheck("tablet", *token, "lab"), absl::OkStatus());
  const absl::Time deadline = absl::Now() + absl::Seconds(40);
  const auto becomes = [&](bool ok) {
    while (watch.Check("tablet", *token, "lab").ok() != ok && absl::Now() < deadline) {
      absl::SleepFor(absl::Milliseconds(5));
    }
    return watch.Check("tablet", *token, "lab").ok() == ok;
  };
  std::ofstream(list) << "tablet\n";
  EXPECT_TRUE(becomes(false));
  EXPECT_EQ(watch.AskAndCheck("tablet", *token, "lab").code(), absl::StatusCode::kUnauthenticated);
  std::ofstream(list) << "other\n";
  EXPECT_TRUE(becomes(true));
}

}  // namespace
}  // namespace corbslam::services
