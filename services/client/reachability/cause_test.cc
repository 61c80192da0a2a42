// Tests each way in which a server is not reached, and the words for it.
#include "services/client/reachability/cause.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "fusion_worker/local_fusion_worker.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"

namespace corbslam::services {

using fusion_worker::MakeLocalFusionWorker;

namespace {

using test_data::TestCertificates;
using ::testing::AllOf;
using ::testing::HasSubstr;

class CauseTest : public ::testing::Test {
 protected:
  // Starts a worker that computes nothing: the tests ask only for what all servers share.
  void Start(const SecurityOptions& options) {
    auto security = MakeServerSecurity(options);
    ASSERT_TRUE(security.ok()) << security.status();
    auto server = Server::Start("127.0.0.1:0", {&service_}, security->server);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  // Returns what a client is told; OK if nothing is wrong.
  static absl::Status Explain(const ServerTarget& target) {
    const std::optional<Cause> cause = FindCause(target, absl::Seconds(10));
    return cause.has_value() ? ToStatus(target, *cause) : absl::OkStatus();
  }
  absl::Status ExplainServer(const SecurityOptions& options,
                             const std::string& service = kFusionWorkerService) const {
    return Explain({server_->address(), service, options});
  }
  std::string Port() const { return server_->address().substr(server_->address().rfind(':')); }

  const std::unique_ptr<FusionWorker> worker_ = MakeLocalFusionWorker();
  FusionWorkerService service_{worker_.get()};
  std::unique_ptr<Server> server_;
};

TEST_F(CauseTest, IsNoneWhereAllIsWell) {
  const TestCertificates certificates("lab");
  Start(certificates.Options("worker"));
  EXPECT_EQ(ExplainServer(certificates.Options("store")), absl::OkStatus());
  Start(WithoutTls());
  EXPECT_EQ(ExplainServer(WithoutTls()), absl::OkStatus());
}

TEST_F(CauseTest, AnImpossibleAddressIsTheCallersMistake) {
  const absl::Status status = Explain({"http://127.0.0.1:1", kMapStoreService, WithoutTls()});
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("give 127.0.0.1:1"));
}

TEST_F(CauseTest, NobodyListens) {
  const absl::Status status = Explain({"127.0.0.1:1", kMapStoreService, WithoutTls()});
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr("no map store answers at 127.0.0.1:1: Connection refused"),
                    HasSubstr("start the map store")));
  EXPECT_THAT(std::string(Explain({"0.0.0.0:1", kFusionWorkerService, WithoutTls()}).message()),
              AllOf(HasSubstr("start the fusion worker"), HasSubstr("0.0.0.0 is for --listen")));
}

TEST_F(CauseTest, TlsOnTheOtherSideOnly) {
  const TestCertificates certificates("lab");
  Start(certificates.Options("worker"));
  EXPECT_THAT(std::string(ExplainServer(WithoutTls()).message()),
              AllOf(HasSubstr("speaks TLS"), HasSubstr("leave --insecure out")));
}

TEST_F(CauseTest, TlsOnThisSideOnly) {
  const TestCertificates certificates("lab");
  Start(WithoutTls());
  EXPECT_THAT(std::string(ExplainServer(certificates.Options("store")).message()),
              AllOf(HasSubstr("speaks no TLS"), HasSubstr("say --insecure here, too")));
}

TEST_F(CauseTest, TheCertificateIsForAnotherHost) {
  const TestCertificates certificates("lab");
  Start(certificates.Options("worker"));
  // 127.0.0.2 is another way to this machine, which the certificate does not name.
  const ServerTarget target = {absl::StrCat("127.0.0.2", Port()), kFusionWorkerService,
                               certificates.Options("store")};
  server_.reset();
  auto security = MakeServerSecurity(certificates.Options("worker"));
  ASSERT_TRUE(security.ok());
  auto server = Server::Start(target.address, {&service_}, security->server);
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_THAT(std::string(Explain(target).message()),
              HasSubstr("certificate of the server there is not for 127.0.0.2"));
}

TEST_F(CauseTest, TheAuthorityIsAnother) {
  const TestCertificates certificates("lab");
  const TestCertificates others("lab");
  Start(certificates.Options("worker"));
  EXPECT_THAT(std::string(ExplainServer(others.Options("store")).message()),
              HasSubstr("does not lead to an authority of --tls-ca"));
}

TEST_F(CauseTest, TheServerKnowsAnotherAuthorityOfItsCallers) {
  const TestCertificates certificates("lab");
  const TestCertificates others("lab");
  Start(certificates.Options("worker"));
  SecurityOptions stranger = certificates.Options("store");
  stranger.certificate_file = others.Options("store").certificate_file;
  stranger.key_file = others.Options("store").key_file;
  const absl::Time begin = absl::Now();
  EXPECT_THAT(std::string(ExplainServer(stranger).message()),
              AllOf(HasSubstr("refuses this side's certificate, --tls-cert"),
                    HasSubstr(stranger.certificate_file),
                    HasSubstr("an authority of the server's --tls-ca")));
  EXPECT_LT(absl::Now() - begin, absl::Seconds(5));
}

TEST_F(CauseTest, TheServerWantsACertificateOfItsCallers) {
  const TestCertificates certificates("lab");
  SecurityOptions closed = certificates.Options("worker");
  closed.health_is_open = false;
  Start(closed);
  SecurityOptions nobody = certificates.Options("store");
  nobody.certificate_file = nobody.key_file = "";
  EXPECT_THAT(std::string(ExplainServer(nobody).message()), HasSubstr("--tls-cert and --tls-key"));
}

TEST_F(CauseTest, AWorkersPortIsNoStores) {
  Start(WithoutTls());
  EXPECT_THAT(std::string(ExplainServer(WithoutTls(), kMapStoreService).message()),
              AllOf(HasSubstr("a fusion worker does, which does not offer corbslam.v1.MapStore"),
                    HasSubstr("map_store says")));
}

TEST_F(CauseTest, AMetricsPortIsNoServersOfOurs) {
  const auto metrics = MetricsEndpoint::Start("127.0.0.1:0", {});
  ASSERT_TRUE(metrics.ok()) << metrics.status();
  const TestCertificates certificates("lab");
  for (const SecurityOptions& options : {WithoutTls(), certificates.Options("store")}) {
    EXPECT_THAT(std::string(Explain({(*metrics)->address(), kMapStoreService, options}).message()),
                HasSubstr("a web server does (HTTP/1)"));
  }
}

// A process that is stopped: its kernel takes connections, and nobody answers them.
class StoppedServer {
 public:
  StoppedServer() : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(socket_, any, size), 0);
    EXPECT_EQ(listen(socket_, 16), 0);
    EXPECT_EQ(getsockname(socket_, any, &size), 0);
    address_ = absl::StrCat("127.0.0.1:", ntohs(address.sin_port));
  }
  ~StoppedServer() { close(socket_); }
  const std::string& address() const { return address_; }

 private:
  const int socket_;
  std::string address_;
};

TEST_F(CauseTest, AServerThatHangsIsSaidToHang) {
  const StoppedServer stopped;
  const TestCertificates certificates("lab");
  for (const SecurityOptions& options : {WithoutTls(), certificates.Options("alpha")}) {
    const absl::Status status =
        ExplainFailure({stopped.address(), kMapStoreService, options},
                       absl::UnavailableError("keepalive watchdog timeout"));
    EXPECT_TRUE(absl::IsUnavailable(status)) << status;
    EXPECT_THAT(std::string(status.message()),
                AllOf(HasSubstr("no answer to keepalives"), HasSubstr("it hangs"),
                      HasSubstr("or the network holds back what is sent")));
  }
  const absl::Status first = ExplainFailure({stopped.address(), kMapStoreService, WithoutTls()},
                                            absl::UnavailableError("failed to connect"));
  EXPECT_THAT(std::string(first.message()), AllOf(HasSubstr("it hangs"), HasSubstr("its log")));
}

TEST_F(CauseTest, OwnFilesAreNoFaultOfTheServer) {
  const TestCertificates certificates("lab");
  Start(certificates.Options("worker"));
  SecurityOptions options = certificates.Options("store");
  options.certificate_file = "/nowhere/alpha.pem";
  EXPECT_THAT(std::string(ExplainServer(options).message()),
              AllOf(HasSubstr("is not called"), HasSubstr("/nowhere/alpha.pem"),
                    HasSubstr("takes it when it comes")));
}

class ProxyCauseTest : public CauseTest {
 protected:
  ~ProxyCauseTest() override {
    unsetenv("http_proxy");
    unsetenv("no_proxy");
  }
};

TEST_F(ProxyCauseTest, AProxyThatIsNotThereIsInTheWay) {
  Start(WithoutTls());
  setenv("http_proxy", "http://me:secret@127.0.0.1:1", 1);
  const std::string said(ExplainServer(WithoutTls()).message());
  EXPECT_THAT(said, AllOf(HasSubstr("http_proxy is set"), HasSubstr("...@127.0.0.1:1"),
                          HasSubstr("Connection refused"), HasSubstr("127.0.0.1 to no_proxy")));
  EXPECT_EQ(said.find("secret"), std::string::npos);
  setenv("no_proxy", "127.0.0.1", 1);
  EXPECT_EQ(ExplainServer(WithoutTls()), absl::OkStatus());
}

// The web server of the metrics refuses to be a proxy.
TEST_F(ProxyCauseTest, AProxyThatRefusesIsQuoted) {
  Start(WithoutTls());
  const auto metrics = MetricsEndpoint::Start("127.0.0.1:0", {});
  ASSERT_TRUE(metrics.ok()) << metrics.status();
  setenv("http_proxy", ("http://" + (*metrics)->address()).c_str(), 1);
  EXPECT_THAT(std::string(ExplainServer(WithoutTls()).message()),
              HasSubstr("which answers \"HTTP/1"));
}

}  // namespace
}  // namespace corbslam::services
