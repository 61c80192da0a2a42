#include "services/client/reachability/protocol_probe.h"

#include <sys/socket.h>

#include <array>
#include <cerrno>

#include "absl/strings/match.h"
#include "services/client/reachability/tcp_probe.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// The preface of HTTP/2 (RFC 9113, 3.4) and an empty SETTINGS frame: 9 bytes, of type 4.
constexpr absl::string_view kGreeting("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);
constexpr char kSettingsFrame = 4;
// Types of TLS records: 0x15 is an alert, 0x16 a handshake.
constexpr char kAlert = 0x15;
constexpr char kHandshake = 0x16;

}  // namespace

Protocol ClassifyAnswer(absl::string_view bytes) {
  if (bytes.empty()) return Protocol::kClosed;
  if (absl::StartsWith(bytes, "HTTP/1.")) return Protocol::kHttp1;
  if (bytes.size() >= 3 && (bytes[0] == kAlert || bytes[0] == kHandshake) && bytes[1] == 3) {
    return Protocol::kTls;
  }
  // Every server's first frame is its SETTINGS, which are short.
  if (bytes.size() >= 9 && bytes[0] == 0 && bytes[3] == kSettingsFrame) return Protocol::kHttp2;
  return Protocol::kOther;
}

absl::StatusOr<Protocol> ProbeProtocol(const HostPort& address, absl::Duration timeout) {
  ASSIGN_OR_RETURN(const Connection connection, Connect(address, timeout));
  connection.MakeBlocking(timeout);
  if (send(connection.socket(), kGreeting.data(), kGreeting.size(), MSG_NOSIGNAL) < 0) {
    return Protocol::kClosed;
  }
  std::array<char, 64> answer;
  const ssize_t size = recv(connection.socket(), answer.data(), answer.size(), 0);
  if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Protocol::kSilent;
  return ClassifyAnswer({answer.data(), size < 0 ? 0 : static_cast<size_t>(size)});
}

}  // namespace corbslam::services
