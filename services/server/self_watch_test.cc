#include "services/server/self_watch.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

// Waits until the watch says so.
bool Becomes(const SelfWatch& watch, bool ok) {
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (watch.status().ok() != ok && absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(5));
  }
  return watch.status().ok() == ok;
}

TEST(SelfWatchTest, AServerAnswersItself) {
  const auto server = Server::Start("127.0.0.1:0", {});
  ASSERT_TRUE(server.ok()) << server.status();
  int changes = 0;
  {
    SelfWatch watch({.address = (*server)->reachable(),
                     .interval = absl::Milliseconds(5),
                     .on_change = [&changes](const absl::Status&) { ++changes; }});
    absl::SleepFor(absl::Milliseconds(100));
    EXPECT_EQ(watch.status(), absl::OkStatus());
  }
  EXPECT_EQ(changes, 0);
}

TEST(SelfWatchTest, APortThatAcceptsNothingIsFound) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  ASSERT_EQ(listen(fd, 100), 0);
  socklen_t length = sizeof(address);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
  {
    const SelfWatch watch({.address = absl::StrCat("127.0.0.1:", ntohs(address.sin_port)),
                           .interval = absl::Milliseconds(5),
                           .patience = absl::Milliseconds(20)});
    EXPECT_TRUE(Becomes(watch, false));
    // Somebody accepts again.
    std::thread server([fd] {
      for (int accepted = accept(fd, nullptr, nullptr); accepted >= 0;
           accepted = accept(fd, nullptr, nullptr)) {
        close(accepted);
      }
    });
    EXPECT_TRUE(Becomes(watch, true));
    shutdown(fd, SHUT_RDWR);
    server.join();
  }
  close(fd);
}

TEST(SelfWatchTest, WhoServesNobodyWorks) {
  const SelfWatch watch({.interval = absl::Milliseconds(1)});
  absl::SleepFor(absl::Milliseconds(10));
  EXPECT_EQ(watch.status(), absl::OkStatus());
}

}  // namespace
}  // namespace corbslam::services
