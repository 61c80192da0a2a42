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

namespace corbslam {
namespace {

using AddressList = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

// Null and the reason in `error` where the host has no address.
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

sockaddr_storage FirstOf(const addrinfo& found) {
  sockaddr_storage address = {};
  std::memcpy(&address, found.ai_addr, std::min<size_t>(found.ai_addrlen, sizeof(address)));
  return address;
}

std::string ExplainTakenPort(const std::string& address) {
  int error = 0;
  const AddressList found = Resolve(address, error);
  const std::optional<pid_t> holder =
      found == nullptr ? std::nullopt : FindPortHolder(FirstOf(*found));
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

}  // namespace

std::string ExplainBindError(const std::string& address, int error) {
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

std::string ExplainListenFailure(const std::string& address) {
  int error = 0;
  const AddressList found = Resolve(address, error);
  if (found == nullptr) return absl::StrCat("the host has no address: ", gai_strerror(error));
  const int fd = socket(found->ai_family, found->ai_socktype | SOCK_CLOEXEC, 0);
  if (fd < 0) return std::strerror(errno);
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  const bool failed = bind(fd, found->ai_addr, found->ai_addrlen) != 0 || listen(fd, 1) != 0;
  error = errno;
  close(fd);
  return failed ? ExplainBindError(address, error)
                : "it could not a moment ago, and can now; start this process again";
}

}  // namespace corbslam
