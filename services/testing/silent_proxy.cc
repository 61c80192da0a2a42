#include "services/testing/silent_proxy.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

sockaddr_in Loopback(int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(port));
  return address;
}

int Socket() { return socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0); }

}  // namespace

absl::StatusOr<std::unique_ptr<SilentProxy>> SilentProxy::Start(const std::string& server) {
  int server_port = 0;
  if (!absl::SimpleAtoi(server.substr(server.rfind(':') + 1), &server_port)) {
    return absl::InvalidArgumentError(absl::StrCat("\"", server, "\" has no port"));
  }
  const int listening = Socket();
  sockaddr_in address = Loopback(0);
  socklen_t size = sizeof(address);
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (listening < 0 || bind(listening, generic, size) != 0 || listen(listening, 16) != 0 ||
      getsockname(listening, generic, &size) != 0) {
    const std::string message = absl::StrCat("no proxy: ", std::strerror(errno));
    close(listening);
    return absl::UnavailableError(message);
  }
  return std::unique_ptr<SilentProxy>(
      new SilentProxy(listening, ntohs(address.sin_port), server_port));
}

SilentProxy::SilentProxy(int listening, int own_port, int server_port)
    : listening_(listening),
      server_port_(server_port),
      address_(absl::StrCat("127.0.0.1:", own_port)),
      accepting_([this] { Accept(); }) {}

SilentProxy::~SilentProxy() {
  shutdown(listening_, SHUT_RDWR);
  accepting_.join();
  for (Connection& connection : connections_) {
    shutdown(connection.client, SHUT_RDWR);
    shutdown(connection.server, SHUT_RDWR);
    connection.up.join();
    connection.down.join();
    close(connection.client);
    close(connection.server);
  }
  close(listening_);
}

void SilentProxy::Accept() {
  while (true) {
    const int client = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) return;
    const int server = Socket();
    const sockaddr_in address = Loopback(server_port_);
    if (connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      close(client);
      close(server);
      continue;
    }
    Connection& made = connections_.emplace_back();
    made.client = client;
    made.server = server;
    made.up = std::thread([this, &made] { Carry(made.client, made.server, made.dead); });
    made.down = std::thread([this, &made] { Carry(made.server, made.client, made.dead); });
  }
}

void SilentProxy::Carry(int from, int to, std::atomic<bool>& dead) {
  std::array<char, 16 << 10> buffer;
  while (true) {
    const ssize_t bytes = recv(from, buffer.data(), buffer.size(), 0);
    if (silent_) dead = true;
    // Once the connection is dead, one side does not learn either that the other hangs up.
    if (bytes <= 0) break;
    if (dead) continue;
    if (send(to, buffer.data(), static_cast<size_t>(bytes), MSG_NOSIGNAL) != bytes) break;
  }
  if (!dead) shutdown(to, SHUT_RDWR);
}

}  // namespace corbslam::services
