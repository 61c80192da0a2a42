// Provides what all our servers share: address, limits, health, reflection and an orderly end.
#ifndef CORBSLAM_SERVICES_SERVER_SERVER_H_
#define CORBSLAM_SERVICES_SERVER_SERVER_H_

#include <grpcpp/channel.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/runtime/connection_book.h"
#include "services/server/call_auditor.h"
#include "services/server/rpc_observer.h"

namespace grpc::experimental {
class ExternalConnectionAcceptor;
}  // namespace grpc::experimental

namespace corbslam::services {

class ConnectionFront;

// A message on the wire has at most so many bytes.
inline constexpr int kMaxMessageBytes = 4 << 20;

// Names that grpc.health.v1.Health knows: whether the process runs (else it is to be restarted),
// and whether it takes calls (else they are to be sent elsewhere). No name at all means the second.
inline constexpr char kLiveness[] = "liveness";
inline constexpr char kReadiness[] = "readiness";

struct ServerOptions {
  // Programs take their credentials from services/security.
  std::shared_ptr<grpc::ServerCredentials> credentials = grpc::InsecureServerCredentials();
  bool reflection = true;
  bool health = true;
  // A caller that was silent for `keepalive_time` is asked for a sign of life, and its calls are
  // cancelled when none comes within `keepalive_timeout`.
  absl::Duration keepalive_time = absl::Seconds(20);
  absl::Duration keepalive_timeout = absl::Seconds(20);
  // Callers with an older connection are told to make a new one, which may lead elsewhere; calls
  // that are under way end on the connection where they began.
  absl::Duration max_connection_age = absl::InfiniteDuration();
  // Within this a connection's TLS and its first words must be done, and a connection without calls
  // is closed after the other.
  absl::Duration handshake_timeout = absl::Seconds(15);
  absl::Duration max_connection_idle = absl::Minutes(5);
  // Connections at one time; fewer where the process may not have as many files. One without calls
  // makes room for a newer one.
  ConnectionLimits connections = {};
  // Hears of every call. Not owned, must outlive the server; null: nobody does.
  RpcObserver* rpc_observer = nullptr;
  // Hears how calls ended; null: nobody does.
  std::shared_ptr<CallAuditor> auditor = nullptr;
};

// A running server. Thread-safe.
class Server {
 public:
  // Serves `services` (not owned, must outlive the server) on "HOST:PORT", with channelz and, as
  // the options say, health and reflection. Port 0: the system chooses one. INVALID_ARGUMENT for an
  // address of another form, UNAVAILABLE where it can't listen. The address may be empty: then only
  // InProcessChannel reaches it.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const std::string& address,
                                                       const std::vector<grpc::Service*>& services,
                                                       const ServerOptions& options = {});
  ~Server();

  // Returns "HOST:PORT" with the port that was chosen.
  const std::string& address() const { return address_; }
  // Returns "IP:PORT" by which this machine reaches it; empty: nothing does.
  std::string reachable() const;
  std::shared_ptr<grpc::Channel> InProcessChannel();
  // Returns what became of its connections.
  ConnectionCounts connections() const;

  // Sets what the health service says of readiness from now on; it is true at the start, and false
  // after Shutdown.
  void SetReady(bool ready);
  // Sets likewise what it says of the process itself: whether it is to be started again.
  void SetAlive(bool alive);

  // Reports that the server isn't ready, tells callers to go elsewhere (GOAWAY), lets calls end by
  // themselves for `drain`, cancels the rest, and returns when all have ended. Called once only;
  // the destructor does it with no drain.
  void Shutdown(absl::Duration drain);

 private:
  Server();

  void HandOver(int listener, int fd);

  // Calls and connections of the gRPC server refer to it to their end.
  std::unique_ptr<ConnectionFront> front_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  std::atomic<bool> stopped_{false};
};

// Blocks SIGTERM and SIGINT in this thread and all that it starts from now on; main calls it first.
void BlockStopSignals();
// Waits for SIGTERM or SIGINT.
void WaitForStopSignal();
// Writes "listening on HOST:PORT" to standard output and flushes it.
void AnnounceAddress(const std::string& address);
// Writes likewise "metrics on HOST:PORT", before the line above.
void AnnounceMetrics(const std::string& address);
// Writes likewise "finished": the program's work is done and it waits to be stopped.
void AnnounceFinished();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_SERVER_H_
