// Tests that a viewer goes on before a store whose authority and tokens were replaced.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/http/browser_options.h"
#include "services/http/testing/raw_http.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/security_options.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"
#include "services/viewer/viewer.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using test_data::TestCertificates;
using testing::Ask;
using testing::MakeRequest;
using testing::StatusOf;

std::string ContentOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Overwrite(const std::string& path, const std::string& text) {
  std::ofstream(path + ".new") << text;
  fs::rename(path + ".new", path);
}

// A map store that shows a certificate of these, and takes tokens of these alone.
class SecureStore {
 public:
  SecureStore(const TestCertificates& certificates, const std::string& address,
              const std::shared_ptr<const Vocabulary>& vocabulary)
      : store_(MapStoreOptions(), vocabulary, std::make_unique<InMemoryJournal>(), nullptr) {
    SecurityOptions options = certificates.Options("store");
    options.ca_file.clear();
    options.token_key_file = certificates.Path("token.pub");
    const auto security = MakeServerSecurity(options);
    EXPECT_TRUE(security.ok()) << security.status();
    if (!security.ok()) return;
    MapStoreServiceOptions guarded;
    guarded.door = security->access;
    service_ = std::make_unique<MapStoreService>(&store_, guarded);
    auto server = Server::Start(address, {service_.get()}, security->server);
    EXPECT_TRUE(server.ok()) << server.status();
    if (server.ok()) server_ = *std::move(server);
  }
  std::string address() const { return server_ == nullptr ? "" : server_->address(); }

 private:
  MapStore store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
};

std::string TokenOf(const TestCertificates& certificates) {
  const auto token = SignToken(
      {{*ParseGrant("missions/lab/viewers/eve")}, absl::Now() + absl::Hours(1), "viewers-token"},
      ContentOf(certificates.Path("token.key")));
  EXPECT_TRUE(token.ok()) << token.status();
  return token.value_or("");
}

TEST(ViewerCredentialsTest, AStoreOfAnotherAuthorityIsFollowedWithoutARestart) {
  const auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
  ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
  const TestCertificates ours("lab");
  const TestCertificates others("lab");
  auto store = std::make_unique<SecureStore>(ours, "127.0.0.1:0", *vocabulary);
  const std::string address = store->address();
  // As map_viewer does it.
  SecurityOptions options;
  options.ca_file = ours.Path("ca.pem");
  options.token_file = ours.Path("viewers.token");
  Overwrite(options.token_file, TokenOf(ours));
  const auto credentials = MakeChannelCredentials(options);
  ASSERT_TRUE(credentials.ok()) << credentials.status();
  Viewer viewer(MakeChannel(address, *credentials), {}, nullptr, PageFiles::Load("/nowhere"),
                ViewerOptions());
  const auto web = WebServer::Start("127.0.0.1:0", &viewer, BrowserOptions());
  ASSERT_TRUE(web.ok()) << web.status();
  // The store answers that it has no such mission.
  const auto ask = [&web] {
    return StatusOf(
        Ask((*web)->address(), MakeRequest("GET", "/api/missions/lab", "Connection: close\r\n")));
  };
  EXPECT_EQ(ask(), 404);

  store.reset();
  store = std::make_unique<SecureStore>(others, address, *vocabulary);
  EXPECT_NE(ask(), 404);
  Overwrite(options.ca_file, ContentOf(others.Path("ca.pem")));
  Overwrite(options.token_file, TokenOf(others));
  const absl::Time deadline = absl::Now() + absl::Seconds(30);
  while (ask() != 404 && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(50));
  EXPECT_EQ(ask(), 404);
}

}  // namespace
}  // namespace corbslam::services
