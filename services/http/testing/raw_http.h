// Sends HTTP as bytes, as a client may that isn't well-behaved.
#ifndef CORBSLAM_SERVICES_HTTP_TESTING_RAW_HTTP_H_
#define CORBSLAM_SERVICES_HTTP_TESTING_RAW_HTTP_H_

#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam::testing {

// A TCP connection to "IP:PORT" (IPv4). Not thread-safe.
class RawConnection {
 public:
  explicit RawConnection(const std::string& address);
  ~RawConnection();
  RawConnection(RawConnection&& other) noexcept;
  RawConnection& operator=(RawConnection&&) = delete;

  bool is_connected() const { return fd_ >= 0; }
  // Returns true if all of it went out.
  bool Send(absl::string_view bytes) const;
  // Tells the server that nothing more will be sent.
  void EndSending() const;
  // Returns everything until the server closes, or until so much time has passed.
  std::string ReadToEnd(absl::Duration patience = absl::Seconds(20));
  // Returns true once the server has closed or reset the connection.
  bool has_ended() const { return ended_; }

 private:
  int fd_ = -1;
  bool ended_ = false;
};

// Returns the whole answer to such a request over a connection of its own; empty if there is none.
std::string Ask(const std::string& address, absl::string_view request);
// Returns "METHOD TARGET HTTP/1.1" with a host, and these headers, each ending in "\r\n".
std::string MakeRequest(absl::string_view method, absl::string_view target,
                        absl::string_view headers = "");
// Returns the status of an answer's first line; 0 if it is none.
int StatusOf(absl::string_view answer);
// Returns what stands behind the headers.
std::string BodyOf(absl::string_view answer);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_HTTP_TESTING_RAW_HTTP_H_
