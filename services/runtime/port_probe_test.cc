#include "services/runtime/port_probe.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <thread>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

// Listens, and accepts nothing by itself.
class Listener {
 public:
  Listener() : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_EQ(listen(fd_, 10), 0);
    socklen_t length = sizeof(address);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &length);
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { close(fd_); }

  int fd() const { return fd_; }
  int port() const { return port_; }

 private:
  const int fd_;
  int port_ = 0;
};

TEST(PortProbeTest, WhoEndsAConnectionHasReadIt) {
  const Listener listener;
  std::thread server([&listener] {
    const int fd = accept(listener.fd(), nullptr, nullptr);
    char text[10];
    while (recv(fd, text, sizeof(text), 0) > 0) continue;
    close(fd);
  });
  EXPECT_EQ(ProbePort(absl::StrCat("0.0.0.0:", listener.port()), absl::Seconds(20)),
            absl::OkStatus());
  server.join();
}

TEST(PortProbeTest, WhoAcceptsNothingIsFound) {
  const Listener listener;
  const absl::Status status =
      ProbePort(absl::StrCat("127.0.0.1:", listener.port()), absl::Milliseconds(50));
  EXPECT_EQ(status.code(), absl::StatusCode::kDeadlineExceeded) << status;
}

TEST(PortProbeTest, WhereNobodyListensThereIsNoConnection) {
  std::string address;
  {
    const Listener listener;
    address = absl::StrCat("127.0.0.1:", listener.port());
  }
  EXPECT_EQ(ProbePort(address, absl::Seconds(1)).code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace corbslam::services
