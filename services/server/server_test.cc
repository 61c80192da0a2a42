#include "services/server/server.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>

#include "absl/time/clock.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/health_client.h"
#include "services/server/process_usage.h"
#include "services/server/readiness_watch.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

constexpr char kAddress[] = "127.0.0.1:0";

std::shared_ptr<grpc::Channel> Connect(const Server& server) {
  return grpc::CreateChannel(server.address(), grpc::InsecureChannelCredentials());
}

TEST(ServerTest, ChoosesAPortAndSaysItIsServing) {
  const auto server = Server::Start(kAddress, {});
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_THAT((*server)->address(), MatchesRegex("127.0.0.1:[1-9][0-9]*"));
  EXPECT_EQ(CheckHealth(Connect(**server), ""), absl::OkStatus());
}

TEST(ServerTest, ReadinessGoesAndComesWhileItLives) {
  const auto server = Server::Start(kAddress, {});
  ASSERT_TRUE(server.ok()) << server.status();
  const auto channel = Connect(**server);
  EXPECT_EQ(CheckHealth(channel, kLiveness), absl::OkStatus());
  EXPECT_EQ(CheckHealth(channel, kReadiness), absl::OkStatus());
  (*server)->SetReady(false);
  EXPECT_EQ(CheckHealth(channel, kLiveness), absl::OkStatus());
  for (const char* name : {kReadiness, ""}) {
    EXPECT_EQ(CheckHealth(channel, name).code(), absl::StatusCode::kFailedPrecondition) << name;
  }
  (*server)->SetReady(true);
  EXPECT_EQ(CheckHealth(channel, kReadiness), absl::OkStatus());
  EXPECT_EQ(CheckHealth(channel, "nothing").code(), absl::StatusCode::kNotFound);
}

TEST(ServerTest, ReadinessFollowsWhatIsWatched) {
  const auto server = Server::Start(kAddress, {});
  ASSERT_TRUE(server.ok()) << server.status();
  const auto channel = Connect(**server);
  std::atomic<bool> works = true;
  ReadinessWatch watch(
      server->get(),
      [&works] { return works ? absl::OkStatus() : absl::ResourceExhaustedError("disk full"); },
      absl::Milliseconds(5));
  const auto becomes = [&channel](absl::StatusCode code) {
    const absl::Time deadline = absl::Now() + absl::Seconds(20);
    while (CheckHealth(channel, kReadiness).code() != code && absl::Now() < deadline) {
      absl::SleepFor(absl::Milliseconds(5));
    }
    return CheckHealth(channel, kReadiness).code() == code;
  };
  works = false;
  EXPECT_TRUE(becomes(absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(CheckHealth(channel, kLiveness), absl::OkStatus()) << "to restart it would not help";
  works = true;
  EXPECT_TRUE(becomes(absl::StatusCode::kOk));
  watch.Stop();
  works = false;
  absl::SleepFor(absl::Milliseconds(50));
  EXPECT_EQ(CheckHealth(channel, kReadiness), absl::OkStatus());
}

TEST(ServerTest, HealthAndReflectionAreThereOrNot) {
  const auto both = Server::Start(kAddress, {});
  ASSERT_TRUE(both.ok()) << both.status();
  EXPECT_THAT(*GenericClient(Connect(**both)).ListServices(), Contains("grpc.health.v1.Health"));
  const auto neither = Server::Start(kAddress, {}, {.reflection = false, .health = false});
  ASSERT_TRUE(neither.ok()) << neither.status();
  const auto channel = Connect(**neither);
  EXPECT_EQ(CheckHealth(channel, "").code(), absl::StatusCode::kUnimplemented);
  EXPECT_EQ(GenericClient(channel).ListServices().status().code(),
            absl::StatusCode::kUnimplemented);
  (*neither)->SetReady(false);
}

TEST(ServerTest, TwoServersDoNotShareAPort) {
  const auto first = Server::Start(kAddress, {});
  ASSERT_TRUE(first.ok());
  const auto second = Server::Start((*first)->address(), {});
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(
      std::string(second.status().message()),
      AllOf(HasSubstr((*first)->address()), HasSubstr("this process itself has this port")));
}

TEST(ServerTest, SaysWhyItCantListen) {
  const auto elsewhere = Server::Start("192.0.2.1:0", {});
  EXPECT_EQ(elsewhere.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(elsewhere.status().message()), HasSubstr("no network interface"));
  const auto unknown = Server::Start("nowhere.invalid:0", {});
  EXPECT_EQ(unknown.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(unknown.status().message()), HasSubstr("the host has no address"));
}

TEST(ServerTest, RefusesWhatIsNoAddress) {
  for (const char* address : {"127.0.0.1", "127.0.0.1:99999", "127.0.0.1:-1", "127.0.0.1:x"}) {
    EXPECT_EQ(Server::Start(address, {}).status().code(), absl::StatusCode::kInvalidArgument)
        << address;
  }
}

TEST(ServerTest, AnnouncesItsAddressForWhoeverStartedIt) {
  ::testing::internal::CaptureStdout();
  AnnounceAddress("127.0.0.1:12");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "listening on 127.0.0.1:12\n");
}

TEST(ProcessUsageTest, IsThatOfThisProcess) {
  const ProcessUsage usage = GetProcessUsage();
  EXPECT_GT(usage.peak_rss_bytes, 1u << 20);
  EXPECT_LT(usage.peak_rss_bytes, 1u << 30);
  EXPECT_GE(usage.cpu_s, 0);
}

TEST(ServerTest, AnOldConnectionIsReplaced) {
  ServerOptions options;
  options.max_connection_age = absl::Milliseconds(300);
  const auto server = Server::Start("127.0.0.1:0", {}, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto channel = Connect(**server);
  for (int connection = 0; connection < 3; ++connection) {
    ASSERT_TRUE(CheckHealth(channel, kReadiness).ok());
    const auto deadline = std::chrono::system_clock::now() + std::chrono::seconds(20);
    EXPECT_TRUE(channel->WaitForStateChange(GRPC_CHANNEL_READY, deadline));
  }
}

}  // namespace
}  // namespace corbslam::services
