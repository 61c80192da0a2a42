#include "services/server/connection_front.h"

#include <arpa/inet.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "corbslam/v1/agent_service.grpc.pb.h"
#include "services/client/remote/health_client.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

int PortOf(const std::string& address) { return std::stoi(address.substr(address.rfind(':') + 1)); }

// A connection of a stranger, from 127.0.0.`host`.
class Stranger {
 public:
  Stranger(const Server& server, uint8_t host) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(0x7f000000u | host);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(PortOf(server.address())));
    EXPECT_EQ(connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  }
  Stranger(Stranger&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  ~Stranger() {
    if (fd_ >= 0) close(fd_);
  }

  // Says what begins HTTP/2, as a client that will never ask.
  void Speak() const {
    const std::string bytes("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);
    EXPECT_EQ(send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  // Returns true if the server has ended it.
  bool IsOver() const {
    char text[1000];
    ssize_t length = 1;
    while (length > 0) length = recv(fd_, text, sizeof(text), MSG_DONTWAIT);
    return length == 0 || (errno != EAGAIN && errno != EINTR);
  }

 private:
  int fd_;
};

bool Eventually(const std::function<bool()>& holds) {
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (!holds() && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(5));
  return holds();
}

size_t CountOver(const std::vector<Stranger>& strangers) {
  size_t over = 0;
  for (const Stranger& stranger : strangers) over += stranger.IsOver() ? 1 : 0;
  return over;
}

std::vector<Stranger> Crowd(const Server& server, uint8_t host, int size, bool speaks) {
  std::vector<Stranger> crowd;
  for (int i = 0; i < size; ++i) {
    crowd.emplace_back(server, host);
    if (speaks) crowd.back().Speak();
  }
  return crowd;
}

std::shared_ptr<grpc::Channel> ConnectAlone(const Server& server) {
  grpc::ChannelArguments own;
  own.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(server.address(), grpc::InsecureChannelCredentials(), own);
}

TEST(ConnectionFrontTest, TheOldestIdleMakesRoomAndTheProbeIsAnswered) {
  for (const bool speaks : {false, true}) {
    ServerOptions options;
    options.connections = {.all = 40, .of_host = 10};
    const auto server = Server::Start("127.0.0.1:0", {}, options);
    ASSERT_TRUE(server.ok()) << server.status();
    std::vector<Stranger> crowd = Crowd(**server, 2, 60, speaks);
    EXPECT_TRUE(Eventually([&] { return CountOver(crowd) >= 50; })) << CountOver(crowd);
    EXPECT_EQ(CheckHealth(ConnectAlone(**server), kLiveness), absl::OkStatus());
    EXPECT_LE((*server)->connections().open, 11u);
    EXPECT_GE((*server)->connections().closed_for_room, 50u);
    crowd.clear();
    EXPECT_TRUE(Eventually([&] { return (*server)->connections().open <= 1; }));
  }
}

// A service with a stream that stays.
class Streams : public v1::Agent::CallbackService {
 public:
  grpc::ServerWriteReactor<v1::WatchPoseResponse>* WatchPose(grpc::CallbackServerContext*,
                                                             const v1::WatchPoseRequest*) override {
    class Stays : public grpc::ServerWriteReactor<v1::WatchPoseResponse> {
      void OnCancel() override { Finish(grpc::Status::CANCELLED); }
      void OnDone() override { delete this; }
    };
    auto* const stays = new Stays;
    stays->StartSendInitialMetadata();
    return stays;
  }
};

void StreamsStayInACrowd(const std::string& address) {
  Streams service;
  ServerOptions options;
  options.connections = {.all = 8, .of_host = 8};
  const auto server = Server::Start(address, {&service}, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto channel = ConnectAlone(**server);
  grpc::ClientContext context;
  const auto stub = v1::Agent::NewStub(channel);
  const auto stream = stub->WatchPose(&context, {});
  stream->WaitForInitialMetadata();
  EXPECT_EQ((*server)->connections().busy, 1u);
  std::vector<std::shared_ptr<grpc::Channel>> others;
  for (int i = 0; i < 30; ++i) {
    others.push_back(ConnectAlone(**server));
    EXPECT_EQ(CheckHealth(others.back(), kLiveness), absl::OkStatus()) << i;
  }
  EXPECT_EQ((*server)->connections().busy, 1u);
  EXPECT_EQ(channel->GetState(false), GRPC_CHANNEL_READY) << "it has a call, and was the oldest";
  context.TryCancel();
  EXPECT_TRUE(Eventually([&] { return (*server)->connections().busy == 0; }));
}

TEST(ConnectionFrontTest, AConnectionWithACallStays) { StreamsStayInACrowd("127.0.0.1:0"); }

TEST(ConnectionFrontTest, SoItIsWithIpv6) {
  const int fd = socket(AF_INET6, SOCK_STREAM, 0);
  sockaddr_in6 address = {};
  address.sin6_family = AF_INET6;
  address.sin6_addr = in6addr_loopback;
  const bool there =
      fd >= 0 && bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  if (fd >= 0) close(fd);
  if (!there) GTEST_SKIP() << "this machine has no IPv6";
  StreamsStayInACrowd("[::1]:0");
}

TEST(ConnectionFrontTest, SilentConnectionsEnd) {
  Streams service;
  auto listening = Listening::Open("127.0.0.1:0");
  ASSERT_TRUE(listening.ok()) << listening.status();
  const int port = listening->port();
  ConnectionFront front(*std::move(listening), [](int, int) { FAIL() << "nothing was said"; },
                        {.limits = {}, .longest_silence = absl::Milliseconds(50)});
  front.Start();
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(port));
  ASSERT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  char byte = 0;
  EXPECT_EQ(recv(fd, &byte, 1, 0), 0) << "the server ends it";
  EXPECT_TRUE(Eventually([&] { return front.counts().open == 0; }));
  close(fd);
}

// Connections held the files of a process, and when they were gone its port stayed deaf.
TEST(ConnectionFrontTest, AServerThatHadNoFilesHearsAgain) {
  const auto server = Server::Start("127.0.0.1:0", {});
  ASSERT_TRUE(server.ok()) << server.status();
  rlimit before = {};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  std::vector<Stranger> crowd = Crowd(**server, 2, 30, true);
  ASSERT_TRUE(Eventually([&] { return (*server)->connections().open >= 30; }));
  // No number is left below the limit.
  rlimit low = before;
  low.rlim_cur = 20;
  std::vector<Stranger> waiting = Crowd(**server, 3, 10, true);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  absl::SleepFor(absl::Milliseconds(300));
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  crowd.clear();
  waiting.clear();
  EXPECT_EQ(CheckHealth(ConnectAlone(**server), kLiveness), absl::OkStatus());
}

}  // namespace
}  // namespace corbslam::services
