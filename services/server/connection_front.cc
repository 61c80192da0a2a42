#include "services/server/connection_front.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <glog/logging.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "services/runtime/file_limit.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

using Id = ConnectionBook::Id;

// What epoll says of: below the first connection's id, the listeners' places and this.
constexpr Id kStop = 15;
constexpr size_t kMostListeners = 15;
// Connections that are accepted before others are looked after.
constexpr int kAtOnce = 64;
constexpr absl::Duration kSweepInterval = absl::Seconds(1);
// A sweep before a connection is refused, or another one closed, is not made more often.
constexpr absl::Duration kUrgentSweepInterval = absl::Milliseconds(50);
constexpr absl::Duration kPauseWithoutFiles = absl::Milliseconds(20);
// Connections that make room at once when the process has no file left.
constexpr int kRoomWithoutFiles = 16;

struct Peer {
  std::string host;  // As HostOfIp.
  std::string name;  // As gRPC spells it, but for what it escapes.
};

Peer DescribePeer(const sockaddr_storage& address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET) {
    const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &ipv4.sin_addr, text, sizeof(text));
    return {text, absl::StrCat("ipv4:", text, ":", ntohs(ipv4.sin_port))};
  }
  const auto& ipv6 = reinterpret_cast<const sockaddr_in6&>(address);
  const int port = ntohs(ipv6.sin6_port);
  if (IN6_IS_ADDR_V4MAPPED(&ipv6.sin6_addr)) {
    inet_ntop(AF_INET, &ipv6.sin6_addr.s6_addr[12], text, sizeof(text));
    return {text, absl::StrCat("ipv4:", text, ":", port)};
  }
  inet_ntop(AF_INET6, &ipv6.sin6_addr, text, sizeof(text));
  return {HostOfIp(text), absl::StrCat("ipv6:[", text, "]:", port)};
}

// Returns the number that the system gives this socket; 0: it is none, or closed.
ino_t SocketOf(int fd) {
  struct stat status = {};
  return fstat(fd, &status) == 0 && S_ISSOCK(status.st_mode) ? status.st_ino : 0;
}

// Ends a connection that gRPC has, if it has it still: gRPC reads its end and closes it.
void ShutDown(int fd, ino_t socket) {
  // Whatever has this number now keeps it until the copy is looked at.
  const int copy = fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (copy < 0) {
    if (SocketOf(fd) == socket) shutdown(fd, SHUT_RDWR);
    return;
  }
  if (SocketOf(copy) == socket) shutdown(copy, SHUT_RDWR);
  close(copy);
}

bool IsOutOfFiles(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

void Watch(int epoll, int operation, int fd, uint32_t events, Id id) {
  epoll_event event = {};
  event.events = events;
  event.data.u64 = id;
  epoll_ctl(epoll, operation, fd, &event);
}

}  // namespace

ConnectionFront::ConnectionFront(Listening listening, HandOver hand_over,
                                 const ConnectionFrontOptions& options)
    : listening_(std::move(listening)),
      reachable_(listening_.reachable()),
      hand_over_(std::move(hand_over)),
      options_(options),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      stop_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

ConnectionFront::~ConnectionFront() {
  Stop();
  close(stop_);
  close(epoll_);
}

void ConnectionFront::Start() {
  Watch(epoll_, EPOLL_CTL_ADD, stop_, EPOLLIN, kStop);
  const size_t count = std::min(listening_.fds().size(), kMostListeners);
  for (size_t i = 0; i < count; ++i) {
    Watch(epoll_, EPOLL_CTL_ADD, listening_.fds()[i], EPOLLIN, i);
  }
  thread_ = StartThread("accept", [this] { Run(); });
}

void ConnectionFront::Stop() {
  if (!thread_.joinable()) return;
  const uint64_t one = 1;
  static_cast<void>(!write(stop_, &one, sizeof(one)));
  thread_.join();
  listening_.Close();
  absl::MutexLock lock(&mutex_);
  for (const auto& [time, id] : silent_) {
    const auto found = connections_.find(id);
    if (found != connections_.end() && found->second.silent) End(id);
  }
}

void ConnectionFront::Run() {
  std::array<epoll_event, 64> events;
  while (true) {
    const int count = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()),
                                 static_cast<int>(absl::ToInt64Milliseconds(TurnsPause())));
    for (int i = 0; i < count; ++i) {
      const Id id = events[static_cast<size_t>(i)].data.u64;
      if (id == kStop) return;
      if (id < kStop) {
        AcceptFrom(listening_.fds()[id]);
      } else {
        OnReadable(id);
      }
    }
    CloseSilent();
    if (paused_ && absl::Now() >= paused_until_) SetListening(true);
    absl::MutexLock lock(&mutex_);
    if (absl::Now() - swept_ >= kSweepInterval) Sweep();
  }
}

absl::Duration ConnectionFront::TurnsPause() const {
  return paused_ ? kPauseWithoutFiles : kSweepInterval / 4;
}

void ConnectionFront::AcceptFrom(int listener) {
  for (int i = 0; i < kAtOnce && !paused_; ++i) {
    sockaddr_storage address = {};
    socklen_t length = sizeof(address);
    const int fd = accept4(listener, reinterpret_cast<sockaddr*>(&address), &length,
                           SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd >= 0) {
      const Peer peer = DescribePeer(address);
      Take(listener, fd, peer.host, peer.name);
      continue;
    }
    if (errno == EINTR || errno == ECONNABORTED) continue;
    if (IsOutOfFiles(errno)) OnNoFile(errno);
    return;
  }
}

void ConnectionFront::Take(int listener, int fd, const std::string& host, std::string peer) {
  const ConnectionLimits limits = LimitsWithin(FileLimit(), options_.limits);
  if (options_.send_timeout > absl::ZeroDuration()) {
    const int timeout_ms = static_cast<int>(absl::ToInt64Milliseconds(options_.send_timeout));
    setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &timeout_ms, sizeof(timeout_ms));
  }
  absl::MutexLock lock(&mutex_);
  // Who had this number is closed.
  if (const auto old = of_fd_.find(fd); old != of_fd_.end()) Forget(old->second);
  if (book_.size() >= std::min(limits.all, limits.of_host) &&
      absl::Now() - swept_ >= kUrgentSweepInterval) {
    Sweep();
  }
  const Id id = next_id_++;
  const ConnectionBook::Verdict verdict = book_.Enter(id, host, limits);
  if (!verdict.taken) {
    ++counts_.refused;
    close(fd);
    LOG_IF(WARNING, refusing_.IsDue(absl::Now()))
        << "a connection of " << host << " is refused: " << book_.size()
        << " are open, and those that count have calls under way; the limits are " << limits.all
        << " in all and " << limits.of_host << " of one host";
    return;
  }
  if (verdict.makes_room.has_value()) {
    ++counts_.closed_for_room;
    End(*verdict.makes_room);
  }
  of_fd_[fd] = id;
  of_peer_[peer] = id;
  connections_[id] = {fd, listener, /*silent=*/true, SocketOf(fd), std::move(peer)};
  silent_.emplace_back(absl::Now(), id);
  Watch(epoll_, EPOLL_CTL_ADD, fd, EPOLLIN | EPOLLRDHUP, id);
}

void ConnectionFront::OnReadable(Id id) {
  int fd = -1;
  int listener = -1;
  {
    absl::MutexLock lock(&mutex_);
    const auto found = connections_.find(id);
    if (found == connections_.end() || !found->second.silent) return;
    fd = found->second.fd;
    listener = found->second.listener;
    char first = 0;
    const ssize_t length = recv(fd, &first, 1, MSG_PEEK | MSG_DONTWAIT);
    if (length < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (length <= 0) return End(id);
    found->second.silent = false;
    book_.Speak(id);
  }
  epoll_ctl(epoll_, EPOLL_CTL_DEL, fd, nullptr);
  // It may ask about calls while it does this.
  hand_over_(listener, fd);
}

void ConnectionFront::OnNoFile(int error) {
  {
    absl::MutexLock lock(&mutex_);
    Sweep();
    for (int i = 0; i < kRoomWithoutFiles; ++i) {
      const std::optional<Id> idlest = book_.TakeIdlest();
      if (!idlest.has_value()) break;
      ++counts_.closed_for_room;
      End(*idlest);
    }
    ++counts_.refused;
    LOG_IF(ERROR, no_file_.IsDue(absl::Now()))
        << "no connection can be accepted: " << std::strerror(error) << "; the limit of files is "
        << FileLimit() << ", " << book_.size()
        << " connections are open. Connections without calls "
        << "are closed; if that is not enough, raise the limit (LimitNOFILE, ulimit -n)";
  }
  paused_until_ = absl::Now() + kPauseWithoutFiles;
  SetListening(false);
}

void ConnectionFront::SetListening(bool on) {
  paused_ = !on;
  const size_t count = std::min(listening_.fds().size(), kMostListeners);
  for (size_t i = 0; i < count; ++i) {
    Watch(epoll_, EPOLL_CTL_MOD, listening_.fds()[i], on ? uint32_t{EPOLLIN} : 0, i);
  }
}

void ConnectionFront::CloseSilent() {
  absl::MutexLock lock(&mutex_);
  const absl::Time now = absl::Now();
  while (!silent_.empty()) {
    const auto [since, id] = silent_.front();
    const auto found = connections_.find(id);
    const bool is_silent = found != connections_.end() && found->second.silent;
    if (is_silent && now - since < options_.longest_silence) return;
    if (is_silent) End(id);
    silent_.pop_front();
  }
}

void ConnectionFront::Sweep() {
  swept_ = absl::Now();
  std::vector<Id> gone;
  for (const auto& [id, connection] : connections_) {
    if (!connection.silent && SocketOf(connection.fd) != connection.socket) gone.push_back(id);
  }
  for (const Id id : gone) Forget(id);
}

void ConnectionFront::End(Id id) {
  const auto found = connections_.find(id);
  if (found == connections_.end()) return;
  const Connection& connection = found->second;
  if (connection.silent) {
    close(connection.fd);
  } else {
    ShutDown(connection.fd, connection.socket);
  }
  Forget(id);
}

void ConnectionFront::Forget(Id id) {
  book_.Leave(id);
  const auto found = connections_.find(id);
  if (found == connections_.end()) return;
  const auto fd = of_fd_.find(found->second.fd);
  if (fd != of_fd_.end() && fd->second == id) of_fd_.erase(fd);
  const auto peer = of_peer_.find(found->second.peer);
  if (peer != of_peer_.end() && peer->second == id) of_peer_.erase(peer);
  connections_.erase(found);
}

ConnectionFront::Id ConnectionFront::BeginCall(absl::string_view peer) {
  const std::string name = absl::StrReplaceAll(peer, {{"%5B", "["}, {"%5D", "]"}});
  absl::MutexLock lock(&mutex_);
  const auto found = of_peer_.find(name);
  if (found == of_peer_.end()) return 0;
  book_.Begin(found->second);
  return found->second;
}

void ConnectionFront::EndCall(Id connection) {
  absl::MutexLock lock(&mutex_);
  book_.End(connection);
}

ConnectionCounts ConnectionFront::counts() const {
  absl::MutexLock lock(&mutex_);
  ConnectionCounts counts = counts_;
  counts.open = book_.size();
  counts.busy = book_.busy();
  counts.limits = LimitsWithin(FileLimit(), options_.limits);
  return counts;
}

}  // namespace corbslam::services
