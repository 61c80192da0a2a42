#include "services/http/testing/raw_http.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"

namespace corbslam::testing {

RawConnection::RawConnection(const std::string& address) {
  const size_t colon = address.rfind(':');
  int port = 0;
  sockaddr_in target = {};
  target.sin_family = AF_INET;
  if (colon == std::string::npos || !absl::SimpleAtoi(address.substr(colon + 1), &port) ||
      inet_pton(AF_INET, address.substr(0, colon).c_str(), &target.sin_addr) != 1) {
    return;
  }
  target.sin_port = htons(static_cast<uint16_t>(port));
  fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(fd_, reinterpret_cast<const sockaddr*>(&target), sizeof(target)) == 0) return;
  close(std::exchange(fd_, -1));
}

RawConnection::~RawConnection() {
  if (fd_ >= 0) close(fd_);
}

RawConnection::RawConnection(RawConnection&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), ended_(other.ended_) {}

bool RawConnection::Send(absl::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent = send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
  return true;
}

void RawConnection::EndSending() const { shutdown(fd_, SHUT_WR); }

std::string RawConnection::ReadToEnd(absl::Duration patience) {
  const absl::Time deadline = absl::Now() + patience;
  std::string all;
  char buffer[4096];
  while (!ended_) {
    const absl::Duration left = std::max(deadline - absl::Now(), absl::ZeroDuration());
    pollfd wait = {fd_, POLLIN, 0};
    if (poll(&wait, 1, static_cast<int>(absl::ToInt64Milliseconds(left))) <= 0) break;
    const ssize_t got = read(fd_, buffer, sizeof(buffer));
    ended_ = got <= 0;
    if (got > 0) all.append(buffer, static_cast<size_t>(got));
  }
  return all;
}

std::string Ask(const std::string& address, absl::string_view request) {
  RawConnection connection(address);
  if (!connection.is_connected()) return "";
  connection.Send(request);
  return connection.ReadToEnd();
}

std::string MakeRequest(absl::string_view method, absl::string_view target,
                        absl::string_view headers) {
  return absl::StrCat(method, " ", target, " HTTP/1.1\r\nHost: x\r\n", headers, "\r\n");
}

int StatusOf(absl::string_view answer) {
  int status = 0;
  if (!absl::ConsumePrefix(&answer, "HTTP/1.1 ")) return 0;
  return absl::SimpleAtoi(answer.substr(0, 3), &status) ? status : 0;
}

std::string BodyOf(absl::string_view answer) {
  const size_t end = answer.find("\r\n\r\n");
  return end == absl::string_view::npos ? "" : std::string(answer.substr(end + 4));
}

}  // namespace corbslam::testing
