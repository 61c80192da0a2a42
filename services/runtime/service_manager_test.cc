#include "services/runtime/service_manager.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

// Hears what a process tells its manager.
class Manager {
 public:
  explicit Manager(const std::string& name) : fd_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path + 1, name.data(), name.size());
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&address), length), 0);
    setenv("NOTIFY_SOCKET", absl::StrCat("@", name).c_str(), 1);
  }
  ~Manager() {
    unsetenv("NOTIFY_SOCKET");
    close(fd_);
  }

  std::string Hear() const {
    char text[200];
    const ssize_t length = recv(fd_, text, sizeof(text), MSG_DONTWAIT);
    return length > 0 ? std::string(text, static_cast<size_t>(length)) : "";
  }

 private:
  const int fd_;
};

TEST(ServiceManagerTest, HearsWhatItIsTold) {
  const Manager manager(absl::StrCat("corbslam_manager_", getpid()));
  EXPECT_TRUE(NotifyServiceManager("READY=1"));
  EXPECT_EQ(manager.Hear(), "READY=1");
}

TEST(ServiceManagerTest, NobodyListensWithoutOne) {
  unsetenv("NOTIFY_SOCKET");
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
  for (const char* path : {"", "@", "relative", "/nowhere/there/is/such/a/socket"}) {
    setenv("NOTIFY_SOCKET", path, 1);
    EXPECT_FALSE(NotifyServiceManager("READY=1")) << path;
  }
  unsetenv("NOTIFY_SOCKET");
}

TEST(ServiceManagerTest, TheWatchdogIsThisProcesses) {
  unsetenv("WATCHDOG_USEC");
  EXPECT_EQ(WatchdogTimeout(), absl::InfiniteDuration());
  setenv("WATCHDOG_USEC", "30000000", 1);
  EXPECT_EQ(WatchdogTimeout(), absl::Seconds(30));
  setenv("WATCHDOG_PID", absl::StrCat(getpid()).c_str(), 1);
  EXPECT_EQ(WatchdogTimeout(), absl::Seconds(30));
  setenv("WATCHDOG_PID", absl::StrCat(getppid()).c_str(), 1);
  EXPECT_EQ(WatchdogTimeout(), absl::InfiniteDuration());
  unsetenv("WATCHDOG_PID");
  setenv("WATCHDOG_USEC", "never", 1);
  EXPECT_EQ(WatchdogTimeout(), absl::InfiniteDuration());
  unsetenv("WATCHDOG_USEC");
}

}  // namespace
}  // namespace corbslam::services
