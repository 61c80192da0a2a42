#include "services/runtime/listen_errors.h"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>

#include "absl/strings/str_cat.h"
#include "services/runtime/port_holder.h"
#include "slam/util/process_name.h"

namespace corbslam::services {
namespace {

using AddressList = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

// Returns null, and the reason in `error`, if the host has no address.
AddressList Resolve(const std::string& address, int& error) {
  const size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  error = getaddrinfo(host.c_str(), address.substr(colon + 1).c_str(), &hints, &found);
  return {error == 0 ? found : nullptr, freeaddrinfo};
}

// Explains that the port is taken; `address` may be null, which means unknown.
std::string ExplainTakenPort(const addrinfo* address) {
  std::optional<pid_t> holder;
  if (address != nullptr) {
    sockaddr_storage wanted = {};
    std::memcpy(&wanted, address->ai_addr, std::min<size_t>(address->ai_addrlen, sizeof(wanted)));
    holder = FindPortHolder(wanted);
  }
  if (holder == getpid()) {
    return "this process itself has this port already; choose another one (0: any that is free)";
  }
  const std::string who =
      holder.has_value()
          ? absl::StrCat(DescribeProcess(*holder), " has this port")
          : "another process has this port; which one can't be told from here (another user's or "
            "container's?), \"ss -ltnp\" as root may say it";
  return absl::StrCat(who, "; stop it, or choose another port (0: any that is free)");
}

std::string Explain(const addrinfo* address, int error) {
  switch (error) {
    case EADDRINUSE:
      return ExplainTakenPort(address);
    case EADDRNOTAVAIL:
      return "no network interface of this machine has this address; choose one that \"ip "
             "address\" "
             "lists, or 0.0.0.0 for all";
    case EACCES:
      return "this user may not listen on ports below 1024; choose a higher one";
    default:
      return std::strerror(error);
  }
}

// Listens as a server does; returns 0, or errno's value.
int TryToListen(const addrinfo& address) {
  const int fd = socket(address.ai_family, address.ai_socktype | SOCK_CLOEXEC, 0);
  if (fd < 0) return errno;
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  const bool listens = bind(fd, address.ai_addr, address.ai_addrlen) == 0 && listen(fd, 1) == 0;
  const int error = listens ? 0 : errno;
  close(fd);
  return error;
}

}  // namespace

std::string ExplainBindError(const std::string& address, int error) {
  int unknown = 0;
  const AddressList found = Resolve(address, unknown);
  return Explain(found.get(), error);
}

std::string ExplainListenFailure(const std::string& address) {
  int error = 0;
  const AddressList found = Resolve(address, error);
  if (found == nullptr) return absl::StrCat("the host has no address: ", gai_strerror(error));
  for (const addrinfo* one = found.get(); one != nullptr; one = one->ai_next) {
    error = TryToListen(*one);
    if (error != 0) return Explain(one, error);
  }
  return "it could not a moment ago, and can now; start this process again";
}

}  // namespace corbslam::services
