#include "services/server/listening.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "absl/strings/str_cat.h"
#include "services/runtime/address.h"
#include "services/runtime/listen_errors.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using AddressList = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

bool MeansAll(const std::string& host) { return host.empty() || host == "0.0.0.0" || host == "::"; }

absl::StatusOr<AddressList> Resolve(const std::string& host, int port) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), absl::StrCat(port).c_str(), &hints, &found);
  if (error != 0) {
    return absl::UnavailableError(absl::StrCat("the host has no address: ", gai_strerror(error)));
  }
  return AddressList(found, freeaddrinfo);
}

void SetOption(int fd, int level, int option, int value) {
  static_cast<void>(setsockopt(fd, level, option, &value, sizeof(value)));
}

// Returns a socket that listens, or -1 with errno. `port` is used unless it is 0.
int ListenOn(const addrinfo& found, int port) {
  const int fd = socket(found.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  // Connections of the process before may still be ending; they don't keep the port from us.
  SetOption(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  SetOption(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  sockaddr_storage address = {};
  std::memcpy(&address, found.ai_addr, found.ai_addrlen);
  const auto wire_port = htons(static_cast<uint16_t>(port));
  if (found.ai_family == AF_INET6) {
    auto& ipv6 = reinterpret_cast<sockaddr_in6&>(address);
    if (port != 0) ipv6.sin6_port = wire_port;
    // The one for all addresses takes IPv4, too.
    SetOption(fd, IPPROTO_IPV6, IPV6_V6ONLY, IN6_IS_ADDR_UNSPECIFIED(&ipv6.sin6_addr) ? 0 : 1);
  } else if (port != 0) {
    reinterpret_cast<sockaddr_in&>(address).sin_port = wire_port;
  }
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), found.ai_addrlen) == 0 &&
      listen(fd, SOMAXCONN) == 0) {
    return fd;
  }
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

int PortOf(int fd) {
  sockaddr_storage address = {};
  socklen_t length = sizeof(address);
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<sockaddr_in&>(address).sin_port);
}

std::string ReachableIp(int fd) {
  sockaddr_storage address = {};
  socklen_t length = sizeof(address);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
  char ip[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET) {
    const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(address);
    if (ipv4.sin_addr.s_addr == htonl(INADDR_ANY)) return "127.0.0.1";
    return inet_ntop(AF_INET, &ipv4.sin_addr, ip, sizeof(ip));
  }
  const auto& ipv6 = reinterpret_cast<const sockaddr_in6&>(address);
  // It takes IPv4, too, which may be the only one that this machine has.
  if (IN6_IS_ADDR_UNSPECIFIED(&ipv6.sin6_addr)) return "127.0.0.1";
  return absl::StrCat("[", inet_ntop(AF_INET6, &ipv6.sin6_addr, ip, sizeof(ip)), "]");
}

}  // namespace

absl::StatusOr<Listening> Listening::Open(const std::string& address) {
  ASSIGN_OR_RETURN(const HostPort parsed, ParseListenAddress(address));
  Listening listening;
  const auto listen_on = [&listening](const addrinfo* list) -> int {
    int error = 0;
    for (const addrinfo* one = list; one != nullptr; one = one->ai_next) {
      const int fd = ListenOn(*one, listening.port_);
      if (fd < 0) {
        // Somebody else would be called by some of the host's addresses.
        if (errno == EADDRINUSE) return errno;
        error = errno;
        continue;
      }
      listening.fds_.push_back(fd);
      if (listening.port_ == 0) listening.port_ = PortOf(fd);
    }
    return listening.fds_.empty() ? error : 0;
  };
  int error = EAFNOSUPPORT;
  if (MeansAll(parsed.host)) {
    const absl::StatusOr<AddressList> all = Resolve("::", parsed.port);
    if (all.ok()) error = listen_on(all->get());
  }
  if (!MeansAll(parsed.host) || error == EAFNOSUPPORT || error == EADDRNOTAVAIL) {
    absl::StatusOr<AddressList> found =
        Resolve(MeansAll(parsed.host) ? "0.0.0.0" : parsed.host, parsed.port);
    if (!found.ok()) {
      return absl::UnavailableError(
          absl::StrCat("can't listen on \"", address, "\": ", found.status().message()));
    }
    error = listen_on(found->get());
  }
  if (error != 0) {
    listening.Close();
    return absl::UnavailableError(
        absl::StrCat("can't listen on \"", address, "\": ", ExplainListenFailure(address)));
  }
  listening.reachable_ = absl::StrCat(ReachableIp(listening.fds_.front()), ":", listening.port_);
  return listening;
}

void Listening::Close() {
  for (const int fd : fds_) close(fd);
  fds_.clear();
}

}  // namespace corbslam::services
