#include "services/runtime/listen_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

sockaddr_in AddressOf(uint32_t host, int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(host);
  address.sin_port = htons(static_cast<uint16_t>(port));
  return address;
}

// Holds a socket of 127.0.0.1 or of all addresses, which listens or is connected to a port of
// 127.0.0.1.
class TakenPort {
 public:
  explicit TakenPort(uint32_t host, int connected_to = 0) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = AddressOf(host, 0);
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    const sockaddr_in target = AddressOf(INADDR_LOOPBACK, connected_to);
    const int done = connected_to == 0
                         ? listen(fd_, 1)
                         : connect(fd_, reinterpret_cast<const sockaddr*>(&target), sizeof(target));
    EXPECT_EQ(done, 0);
    socklen_t size = sizeof(address);
    EXPECT_EQ(getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  ~TakenPort() { close(fd_); }
  void LeaveToOthers() { close(std::exchange(fd_, -1)); }
  int port() const { return port_; }
  std::string address() const { return absl::StrCat("127.0.0.1:", port_); }

 private:
  int fd_;
  int port_ = 0;
};

TEST(ListenErrorsTest, APortOfThisProcessIsSaid) {
  for (const uint32_t host : {INADDR_LOOPBACK, INADDR_ANY}) {
    const TakenPort taken(host);
    EXPECT_THAT(
        ExplainListenFailure(taken.address()),
        AllOf(StartsWith("this process itself has this port"), HasSubstr("choose another")));
    EXPECT_THAT(ExplainListenFailure(absl::StrCat("0.0.0.0:", taken.port())),
                StartsWith("this process itself has this port"));
  }
}

TEST(ListenErrorsTest, APortOfAnotherProcessIsSaidWithItsProgram) {
  const TakenPort server(INADDR_LOOPBACK);
  for (const int connected_to : {0, server.port()}) {
    TakenPort taken(INADDR_LOOPBACK, connected_to);
    const pid_t other = fork();
    if (other == 0) {
      pause();
      _exit(0);
    }
    taken.LeaveToOthers();
    EXPECT_THAT(ExplainBindError(taken.address(), EADDRINUSE),
                AllOf(StartsWith(absl::StrCat("process ", other, " (")), HasSubstr("stop it")))
        << (connected_to == 0 ? "it listens" : "it has the port for a connection");
    kill(other, SIGKILL);
    waitpid(other, nullptr, 0);
  }
}

TEST(ListenErrorsTest, APortThatNobodyIsSeenToHaveIsSaid) {
  std::string address;
  {
    const TakenPort gone(INADDR_LOOPBACK);
    address = gone.address();
  }
  EXPECT_THAT(ExplainBindError(address, EADDRINUSE), HasSubstr("can't be told from here"));
  EXPECT_THAT(ExplainListenFailure(address), HasSubstr("start this process again"));
}

TEST(ListenErrorsTest, OtherReasonsSayWhatToDo) {
  // 192.0.2.1 is an address of a network for documentation (RFC 5737).
  EXPECT_THAT(ExplainListenFailure("192.0.2.1:0"), HasSubstr("no network interface"));
  EXPECT_THAT(ExplainListenFailure("nowhere.invalid:50051"), HasSubstr("the host has no address"));
  EXPECT_THAT(ExplainBindError("127.0.0.1:80", EACCES), HasSubstr("below 1024"));
  EXPECT_THAT(ExplainListenFailure("[::1"), HasSubstr("the host has no address"));
}

}  // namespace
}  // namespace corbslam::services
