// Tests what the probes make of servers of different kinds, and of none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "services/client/reachability/protocol_probe.h"
#include "services/client/reachability/proxy.h"
#include "services/client/reachability/tcp_probe.h"
#include "services/client/reachability/tls_probe.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

using test_data::TestCertificates;
using ::testing::HasSubstr;

constexpr absl::Duration kPatience = absl::Seconds(20);

HostPort AddressOf(const Server& server) { return *ParseServerAddress(server.address()); }

TEST(TcpProbeTest, SaysThatNobodyListens) {
  // Port 1 is reserved for tcpmux, which nobody runs.
  const absl::Status status = ProbeTcp({"127.0.0.1", 1}, kPatience);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("Connection refused"));
}

TEST(ProtocolProbeTest, KnowsAServerWithoutTls) {
  const auto server = Server::Start("127.0.0.1:0", {});
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_EQ(*ProbeProtocol(AddressOf(**server), kPatience), Protocol::kHttp2);
  EXPECT_EQ(FetchCertificates(AddressOf(**server), kPatience).status().code(),
            absl::StatusCode::kUnavailable);
}

TEST(ProtocolProbeTest, KnowsAServerWithTls) {
  const TestCertificates certificates("lab");
  const auto security = MakeServerSecurity(certificates.Options("worker"));
  ASSERT_TRUE(security.ok()) << security.status();
  const auto server = Server::Start("127.0.0.1:0", {}, security->server);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto protocol = ProbeProtocol(AddressOf(**server), kPatience);
  ASSERT_TRUE(protocol.ok()) << protocol.status();
  EXPECT_TRUE(*protocol == Protocol::kTls || *protocol == Protocol::kClosed);
  EXPECT_THAT(*FetchCertificates(AddressOf(**server), kPatience), HasSubstr("BEGIN CERTIFICATE"));
}

TEST(ProtocolProbeTest, KnowsAWebServer) {
  const auto metrics = MetricsEndpoint::Start("127.0.0.1:0", {});
  ASSERT_TRUE(metrics.ok()) << metrics.status();
  const auto protocol = ProbeProtocol(*ParseServerAddress((*metrics)->address()), kPatience);
  ASSERT_TRUE(protocol.ok()) << protocol.status();
  EXPECT_EQ(*protocol, Protocol::kHttp1);
}

TEST(ProtocolProbeTest, ReadsHowAnAnswerBegins) {
  EXPECT_EQ(ClassifyAnswer(""), Protocol::kClosed);
  EXPECT_EQ(ClassifyAnswer("HTTP/1.1 400 Bad Request"), Protocol::kHttp1);
  EXPECT_EQ(ClassifyAnswer("\x15\x03\x01"), Protocol::kTls);
  EXPECT_EQ(ClassifyAnswer(absl::string_view("\0\0\x06\4\0\0\0\0\0", 9)), Protocol::kHttp2);
  EXPECT_EQ(ClassifyAnswer("SSH-2.0-OpenSSH_9.2"), Protocol::kOther);
}

std::optional<Proxy> FindIn(const std::map<std::string, std::string>& environment,
                            const std::string& host) {
  return FindProxy(host, [&](const char* name) -> const char* {
    const auto it = environment.find(name);
    return it == environment.end() ? nullptr : it->second.c_str();
  });
}

TEST(ProxyTest, IsTheFirstVariableThatGrpcLooksAt) {
  EXPECT_FALSE(FindIn({}, "store.lan").has_value());
  const auto proxy = FindIn(
      {{"http_proxy", "http://10.0.0.1:3128/"}, {"https_proxy", "http://me:secret@proxy.lan:8080"}},
      "store.lan");
  ASSERT_TRUE(proxy.has_value());
  EXPECT_EQ(proxy->variable, "https_proxy");
  EXPECT_EQ(proxy->url, "http://...@proxy.lan:8080");
  ASSERT_TRUE(proxy->address.has_value());
  EXPECT_EQ(ToString(*proxy->address), "proxy.lan:8080");
  EXPECT_FALSE(FindIn({{"grpc_proxy", ""}, {"http_proxy", "http://10.0.0.1:3128"}}, "store.lan"));
  EXPECT_FALSE(FindIn({{"HTTP_PROXY", "http://10.0.0.1:3128"}}, "store.lan"));
  EXPECT_FALSE(FindIn({{"http_proxy", "socks5://10.0.0.1:1080"}}, "store.lan"));
}

TEST(ProxyTest, IsNotForHostsThatAreExcepted) {
  std::map<std::string, std::string> environment = {{"http_proxy", "http://10.0.0.1:3128"},
                                                    {"no_proxy", "localhost,.lan"}};
  EXPECT_FALSE(FindIn(environment, "store.LAN"));
  EXPECT_TRUE(FindIn(environment, "127.0.0.1"));
  environment["no_grpc_proxy"] = "127.0.0.1";
  EXPECT_FALSE(FindIn(environment, "127.0.0.1"));
  EXPECT_TRUE(FindIn(environment, "store.lan"));
}

}  // namespace
}  // namespace corbslam::services
