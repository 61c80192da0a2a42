#include "map_store/testing/cutting_proxy.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace corbslam::testing {
namespace {

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(port));
  return address;
}

// Returns what has come; empty: the connection has ended.
std::string ReadSome(int fd) {
  std::array<char, 65536> buffer;
  const ssize_t size = read(fd, buffer.data(), buffer.size());
  return std::string(buffer.data(), static_cast<size_t>(std::max<ssize_t>(size, 0)));
}

bool WriteAll(int fd, const std::string& bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t size = send(fd, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (size <= 0) return false;
    done += static_cast<size_t>(size);
  }
  return true;
}

}  // namespace

CuttingProxy::CuttingProxy(int server_port) : server_port_(server_port) {
  // A server that a test starts must not hold what is closed here.
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = Loopback(0);
  socklen_t size = sizeof(address);
  EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(listen(listener_, 16), 0);
  EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
  port_ = ntohs(address.sin_port);
  EXPECT_EQ(pipe2(wake_, O_CLOEXEC), 0);
  thread_ = std::thread([this] { Run(); });
}

CuttingProxy::~CuttingProxy() {
  EXPECT_EQ(write(wake_[1], "x", 1), 1);
  thread_.join();
  for (const Pair& pair : pairs_) {
    close(pair.client);
    close(pair.server);
  }
  for (const int fd : {listener_, wake_[0], wake_[1]}) close(fd);
}

void CuttingProxy::CutAt(const std::string& words, Moment moment, int times) {
  absl::MutexLock lock(&mutex_);
  words_ = words;
  moment_ = moment;
  times_ = times;
}

int CuttingProxy::cuts() const {
  absl::MutexLock lock(&mutex_);
  return cuts_;
}

CuttingProxy::Moment CuttingProxy::Judge(const std::string& bytes) {
  absl::MutexLock lock(&mutex_);
  if (times_ == 0 || bytes.find(words_) == std::string::npos) return Moment::kNever;
  --times_;
  ++cuts_;
  return moment_;
}

void CuttingProxy::Accept() {
  Pair pair;
  pair.client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  pair.server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = Loopback(server_port_);
  if (connect(pair.server, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) {
    pairs_.push_back(pair);
    return;
  }
  close(pair.client);
  close(pair.server);
}

bool CuttingProxy::PassOn(Pair& pair) {
  const std::string bytes = ReadSome(pair.client);
  if (bytes.empty()) return false;
  const Moment moment = Judge(bytes);
  if (moment == Moment::kBefore) return false;
  pair.is_doomed |= moment == Moment::kAfter;
  return WriteAll(pair.server, bytes);
}

bool CuttingProxy::PassBack(Pair& pair) {
  const std::string bytes = ReadSome(pair.server);
  return !bytes.empty() && !pair.is_doomed && WriteAll(pair.client, bytes);
}

void CuttingProxy::Run() {
  while (true) {
    std::vector<pollfd> waits = {{wake_[0], POLLIN, 0}, {listener_, POLLIN, 0}};
    for (const Pair& pair : pairs_) {
      waits.push_back({pair.client, POLLIN, 0});
      waits.push_back({pair.server, POLLIN, 0});
    }
    if (poll(waits.data(), waits.size(), -1) <= 0) continue;
    if (waits[0].revents != 0) return;
    std::vector<Pair> going_on;
    for (size_t i = 0; i < pairs_.size(); ++i) {
      Pair& pair = pairs_[i];
      bool goes_on = waits[2 + 2 * i].revents == 0 || PassOn(pair);
      goes_on = goes_on && (waits[3 + 2 * i].revents == 0 || PassBack(pair));
      if (goes_on) {
        going_on.push_back(pair);
      } else {
        close(pair.client);
        close(pair.server);
      }
    }
    pairs_ = going_on;
    if (waits[1].revents != 0) Accept();
  }
}

}  // namespace corbslam::testing
