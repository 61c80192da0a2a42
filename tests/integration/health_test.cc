// Runs the program of containers' health checks against servers of every kind.
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "services/security/security_options.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"

namespace corbslam::tests {

using services::MakeServerSecurity;
using services::SecurityOptions;
using services::Server;
using services::ServerOptions;

namespace {

// Returns its exit code; `environment` has entries "NAME=VALUE".
int RunHealth(const std::vector<std::string>& environment,
              const std::vector<std::string>& arguments) {
  const std::string command =
      absl::StrCat("env ", absl::StrJoin(environment, " "), " '" CORBSLAM_PROGRAMS_DIR "/health' ",
                   absl::StrJoin(arguments, " "), " 2>&1");
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::unique_ptr<Server> Serve(const ServerOptions& options) {
  auto server = Server::Start("127.0.0.1:0", {}, options);
  EXPECT_TRUE(server.ok()) << server.status();
  return server.ok() ? *std::move(server) : nullptr;
}

TEST(HealthTest, SaysHowAServerIs) {
  const auto server = Serve({});
  const std::string address = "CORBSLAM_HEALTH_ADDRESS=" + server->address();
  EXPECT_EQ(RunHealth({address}, {}), 0);
  EXPECT_EQ(RunHealth({}, {"liveness", server->address()}), 0);
  server->SetReady(false);
  EXPECT_EQ(RunHealth({address}, {}), 1);
  EXPECT_EQ(RunHealth({address}, {"liveness"}), 0);
  EXPECT_EQ(RunHealth({address}, {"no_such_service"}), 1);
}

TEST(HealthTest, NobodyIsNotHealthyAndNothingToAskIs) {
  std::string address;
  address = Serve({})->address();
  EXPECT_EQ(RunHealth({}, {"readiness", address}), 1);
  EXPECT_EQ(RunHealth({"CORBSLAM_HEALTH_ADDRESS="}, {}), 0);
}

TEST(HealthTest, OfTlsOnlyTheAuthorityCounts) {
  // The server's certificate is for other names than the address.
  const test_data::TestCertificates certificates("lab");
  const test_data::TestCertificates others("lab");
  const auto security = MakeServerSecurity(certificates.Options("store"));
  ASSERT_TRUE(security.ok()) << security.status();
  const auto server = Serve(security->server);
  const std::string ca = "CORBSLAM_HEALTH_CA=" + certificates.Path("ca.pem");
  EXPECT_EQ(RunHealth({ca}, {"readiness", server->address()}), 0);
  EXPECT_EQ(
      RunHealth({"CORBSLAM_HEALTH_CA=" + others.Path("ca.pem")}, {"readiness", server->address()}),
      1);
  EXPECT_EQ(RunHealth({}, {"readiness", server->address()}), 1);
}

TEST(HealthTest, WhereHealthIsClosedItSaysWhoItIs) {
  const test_data::TestCertificates certificates("lab");
  SecurityOptions options = certificates.Options("store");
  options.health_is_open = false;
  const auto security = MakeServerSecurity(options);
  ASSERT_TRUE(security.ok()) << security.status();
  const auto server = Serve(security->server);
  const std::string ca = "CORBSLAM_HEALTH_CA=" + certificates.Path("ca.pem");
  EXPECT_EQ(RunHealth({ca}, {"readiness", server->address()}), 1);
  EXPECT_EQ(RunHealth({ca, "CORBSLAM_HEALTH_CERT=" + certificates.Path("viewer.pem"),
                       "CORBSLAM_HEALTH_KEY=" + certificates.Path("viewer.key")},
                      {"readiness", server->address()}),
            0);
}

}  // namespace
}  // namespace corbslam::tests
