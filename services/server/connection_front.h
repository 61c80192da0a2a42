// Accepts a gRPC server's connections in its place, and keeps their number within bounds.
#ifndef CORBSLAM_SERVICES_SERVER_CONNECTION_FRONT_H_
#define CORBSLAM_SERVICES_SERVER_CONNECTION_FRONT_H_

#include <sys/types.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "services/runtime/connection_book.h"
#include "services/server/listening.h"
#include "services/server/served_ports.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::services {

struct ConnectionFrontOptions {
  // Fewer where the process may not have as many files (LimitsWithin).
  ConnectionLimits limits;
  // A connection on which nothing came for so long is closed; gRPC never knew of it.
  absl::Duration longest_silence = absl::Seconds(10);
  // What is sent and not acknowledged for so long ends a connection; zero: the system decides.
  absl::Duration send_timeout = absl::ZeroDuration();
};

// gRPC accepts without a bound and, once the process has had no file left, never again
// (grpc 1.51, tcp_server_posix.cc). So this accepts: it waits for a connection's first byte and
// hands it over then. A connection without a call of ours makes room for a newer one. Thread-safe.
class ConnectionFront {
 public:
  // Takes over the connection `fd`, which came to `listener`, and closes it in the end.
  using HandOver = std::function<void(int listener, int fd)>;
  using Id = ConnectionBook::Id;

  ConnectionFront(Listening listening, HandOver hand_over, const ConnectionFrontOptions& options);
  // Stops.
  ~ConnectionFront();
  ConnectionFront(const ConnectionFront&) = delete;
  ConnectionFront& operator=(const ConnectionFront&) = delete;

  // Begins to accept. Called once.
  void Start();
  // Takes no more connections; those that said nothing yet are closed. Called once at most.
  void Stop();

  // A call begins on the connection of `peer`, as gRPC spells it; returns what ends it, 0 where
  // there is no such connection.
  Id BeginCall(absl::string_view peer);
  void EndCall(Id connection);

  ConnectionCounts counts() const;
  // Returns "IP:PORT" by which this machine reaches it.
  const std::string& reachable() const { return reachable_; }

 private:
  struct Connection {
    int fd = -1;
    int listener = -1;
    bool silent = true;  // It is still ours.
    ino_t socket = 0;    // Tells it from a later one of the same number.
    std::string peer;
  };

  void Run();
  absl::Duration TurnsPause() const;
  void AcceptFrom(int listener);
  void Take(int listener, int fd, const std::string& host, std::string peer)
      ABSL_LOCKS_EXCLUDED(mutex_);
  void OnReadable(Id id) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnNoFile(int error) ABSL_LOCKS_EXCLUDED(mutex_);
  void SetListening(bool on);
  void CloseSilent() ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets connections that gRPC has closed.
  void Sweep() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void End(Id id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Forget(Id id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Listening listening_;
  const std::string reachable_;
  const HandOver hand_over_;
  const ConnectionFrontOptions options_;
  const int epoll_;
  const int stop_;  // An eventfd.

  // Only the thread uses these.
  absl::Time paused_until_ = absl::InfinitePast();
  bool paused_ = false;
  RareReminder no_file_;
  RareReminder refusing_;
  std::deque<std::pair<absl::Time, Id>> silent_;  // The oldest comes first.

  mutable absl::Mutex mutex_;
  ConnectionBook book_ ABSL_GUARDED_BY(mutex_);
  ConnectionCounts counts_ ABSL_GUARDED_BY(mutex_);
  Id next_id_ ABSL_GUARDED_BY(mutex_) = 16;
  absl::Time swept_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  std::unordered_map<Id, Connection> connections_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<int, Id> of_fd_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<std::string, Id> of_peer_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
  // Declared last, so that nobody asks for counts that are gone.
  const ServedPort port_{"grpc", [this] { return counts(); }};
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_CONNECTION_FRONT_H_
