// Tests that a store proves who it is, by files that are read again, and that it finds out whether
// the server is the right one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/testing/postgres_server.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;
using testing::PostgresServer;

class PostgresAccessTest : public ::testing::Test {
 protected:
  PostgresAccessTest() {
    // Certificates of two authorities; the server's is of the first.
    Run("openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=authority"
        " -keyout ca.key -out ca.crt");
    Run("openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=other"
        " -keyout other.key -out other.crt");
    MakeCertificate("server", "localhost");
    MakeCertificate("client", "with_certificate");
    // The server takes files of its own user alone.
    Run("cp server.crt server.key ca.crt pg_hba.conf DATA && chown --reference=DATA DATA/server.crt"
        " DATA/server.key DATA/ca.crt DATA/pg_hba.conf");
    for (const char* setting : {"ssl = on", "ssl_cert_file = 'server.crt'",
                                "ssl_key_file = 'server.key'", "ssl_ca_file = 'ca.crt'"}) {
      server_.Ask("postgres", absl::StrCat("ALTER SYSTEM SET ", setting));
    }
    server_.Ask("postgres", "SELECT pg_reload_conf()");
    for (const char* role : {"with_password", "with_certificate"}) {
      server_.Ask("postgres", absl::StrCat("DROP ROLE IF EXISTS ", role));
      server_.Ask("postgres", absl::StrCat("CREATE ROLE ", role, " LOGIN IN ROLE corbslam"));
    }
    // Until the server has read its settings, it has no TLS.
    const absl::Time until = absl::Now() + absl::Seconds(20);
    while (!Try("with_certificate", ByCertificate("ca")).ok() && absl::Now() < until) {
      absl::SleepFor(absl::Milliseconds(50));
    }
  }
  ~PostgresAccessTest() override {
    server_.Ask("postgres", "ALTER SYSTEM RESET ALL");
    server_.Ask("postgres", "SELECT pg_reload_conf()");
  }

  void Run(const std::string& command) const {
    const std::string data = server_.folder() + "/data";
    std::string whole = absl::StrCat("cd ", folder_, " && { ", command, "; } >log 2>&1");
    for (size_t at = whole.find("DATA"); at != std::string::npos; at = whole.find("DATA")) {
      whole.replace(at, 4, data);
    }
    EXPECT_EQ(std::system(whole.c_str()), 0) << whole;
  }
  void MakeCertificate(const std::string& file, const std::string& name) const {
    Write("names", absl::StrCat("subjectAltName=DNS:", name, "\n"));
    Run(absl::StrCat("openssl req -newkey rsa:2048 -nodes -subj /CN=", name, " -keyout ", file,
                     ".key -out request && openssl x509 -req -in request -CA ca.crt -CAkey ca.key"
                     " -CAcreateserial -days 2 -extfile names -out ",
                     file, ".crt && chmod 600 ", file, ".key"));
    Write("pg_hba.conf",
          "local all postgres trust\nlocal all corbslam trust\n"
          "host all with_password samehost scram-sha-256\n"
          "hostssl all with_certificate samehost cert\n"
          "host all corbslam samehost trust\n");
  }
  void Write(const std::string& file, const std::string& text) const {
    std::ofstream(absl::StrCat(folder_, "/", file)) << text;
  }
  std::string ByCertificate(const std::string& authority) const {
    return absl::StrCat("&sslrootcert=", folder_, "/", authority, ".crt&sslcert=", folder_,
                        "/client.crt&sslkey=", folder_, "/client.key");
  }
  absl::Status Try(const std::string& role, const std::string& more,
                   const std::string& host = "localhost",
                   const std::string& mode = "verify-full") const {
    PostgresJournalOptions options{.uri = absl::StrCat("postgresql://", role, "@", host, ":",
                                                       server_.port(), "/", database_,
                                                       "?sslmode=", mode, more)};
    if (role == "with_password") options.password_file = folder_ + "/password";
    return PostgresJournal::Open(options).status();
  }

  PostgresServer& server_ = PostgresServer::Get();
  const std::string database_ = server_.MakeDatabase();
  const std::string folder_ = [] {
    const std::string folder = ::testing::TempDir() + "/postgres_access";
    mkdir(folder.c_str(), 0700);
    return folder;
  }();
};

TEST_F(PostgresAccessTest, TheServerAndTheStoreProveWhoTheyAre) {
  const absl::Status taken = Try("with_certificate", ByCertificate("ca"));
  EXPECT_TRUE(taken.ok()) << taken;
  // Another authority's server, a server of another name, and a store without a certificate.
  const absl::Status other = Try("with_certificate", ByCertificate("other"));
  EXPECT_TRUE(absl::IsUnavailable(other)) << other;
  EXPECT_THAT(std::string(other.message()), HasSubstr("certificate verify failed"));
  const absl::Status renamed = Try("with_certificate", ByCertificate("ca"), "127.0.0.1");
  EXPECT_THAT(std::string(renamed.message()), HasSubstr("does not match host name"));
  const std::string no_certificate =
      absl::StrCat("&sslrootcert=", folder_, "/ca.crt&sslcert=/none&sslkey=/none");
  EXPECT_TRUE(absl::IsUnavailable(Try("with_certificate", no_certificate)));

  server_.Ask("postgres", "ALTER ROLE with_password PASSWORD 'first'");
  const std::string authority = absl::StrCat("&sslrootcert=", folder_, "/ca.crt");
  EXPECT_THAT(std::string(Try("with_password", authority).message()),
              HasSubstr("/password can't be read"));
  Write("password", "first\n");
  EXPECT_TRUE(Try("with_password", authority).ok());
  // What stands in the file is read again, by a journal that is open, too.
  PostgresJournalOptions options{
      .uri = absl::StrCat("postgresql://with_password@localhost:", server_.port(), "/", database_,
                          "?sslmode=verify-full", authority),
      .password_file = folder_ + "/password"};
  auto journal = PostgresJournal::Open(options);
  ASSERT_TRUE(journal.ok()) << journal.status();
  server_.Ask("postgres", "ALTER ROLE with_password PASSWORD 'second'");
  server_.Ask("postgres",
              "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE usename = "
              "'with_password'");
  const absl::Status refused = (*journal)->CheckWritable();
  EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("password authentication failed"));
  Write("password", "second\n");
  EXPECT_TRUE((*journal)->CheckWritable().ok());
}

}  // namespace
}  // namespace corbslam::map_store
