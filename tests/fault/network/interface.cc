#include "tests/fault/network/interface.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {
namespace {

absl::Status Failed(const std::string& name, absl::string_view what) {
  const int error = errno;
  const std::string message = absl::StrCat("device ", name, ": ", what, ": ", std::strerror(error));
  if (error == EPERM || error == EACCES) return absl::PermissionDeniedError(message);
  return absl::UnavailableError(message);
}

ifreq RequestFor(const std::string& name) {
  ifreq request = {};
  std::strncpy(request.ifr_name, name.c_str(), IFNAMSIZ - 1);
  return request;
}

// Makes one setting of a device, through a socket as the system wants it.
absl::Status Configure(const std::string& name, unsigned long setting, ifreq& request,
                       absl::string_view what) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return Failed(name, "no socket");
  const absl::Cleanup closing = [socket] { close(socket); };
  return ioctl(socket, setting, &request) == 0 ? absl::OkStatus() : Failed(name, what);
}

absl::Status SetAddress(const std::string& name, unsigned long setting, const std::string& text) {
  ifreq request = RequestFor(name);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  if (inet_pton(AF_INET, text.c_str(), &address.sin_addr) != 1) {
    return absl::InvalidArgumentError(absl::StrCat("\"", text, "\" is no IPv4 address"));
  }
  std::memcpy(&request.ifr_addr, &address, sizeof(address));
  return Configure(name, setting, request, text);
}

}  // namespace

absl::Status BringUp(const std::string& name) {
  ifreq request = RequestFor(name);
  RETURN_IF_ERROR(Configure(name, SIOCGIFFLAGS, request, "can't read its flags"));
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  return Configure(name, SIOCSIFFLAGS, request, "can't be switched on");
}

absl::StatusOr<int> OpenTunnel(const std::string& name, const std::string& address,
                               const std::string& peer) {
  const int file = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return Failed(name, "/dev/net/tun");
  absl::Cleanup closing = [file] { close(file); };
  ifreq request = RequestFor(name);
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  if (ioctl(file, TUNSETIFF, &request) != 0) return Failed(name, "can't be made");
  RETURN_IF_ERROR(SetAddress(name, SIOCSIFADDR, address));
  RETURN_IF_ERROR(SetAddress(name, SIOCSIFDSTADDR, peer));
  RETURN_IF_ERROR(BringUp(name));
  std::move(closing).Cancel();
  return file;
}

}  // namespace corbslam::tests
