// What all our servers share: address, limits, health, reflection and an orderly end.
#ifndef CORBSLAM_SERVICES_SERVER_SERVER_H_
#define CORBSLAM_SERVICES_SERVER_SERVER_H_

#include <grpcpp/channel.h>
#include <grpcpp/server.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace corbslam {

// No message on the wire is longer.
inline constexpr int kMaxMessageBytes = 4 << 20;

// A running server. Thread-safe.
class Server {
 public:
  // Serves `services` (not owned, must outlive the server) on "HOST:PORT", with health, reflection
  // and channelz. Port 0: the system chooses one. INVALID_ARGUMENT for an address of another form,
  // UNAVAILABLE where it can't listen. The address may be empty: then only InProcessChannel reaches
  // it.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const std::string& address,
                                                       const std::vector<grpc::Service*>& services);
  ~Server();

  // "HOST:PORT" with the port that was chosen.
  const std::string& address() const { return address_; }
  std::shared_ptr<grpc::Channel> InProcessChannel();

  // Reports NOT_SERVING, lets calls end by themselves for `drain`, cancels the rest, and returns
  // when all have ended. Once only; the destructor does it with no drain.
  void Shutdown(absl::Duration drain);

 private:
  Server() = default;

  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  bool stopped_ = false;
};

// Blocks SIGTERM and SIGINT in this thread and all it starts from now on. Call first in main.
void BlockStopSignals();
// Waits for one of them.
void WaitForStopSignal();
// Writes "listening on HOST:PORT" to standard output and flushes it.
void AnnounceAddress(const std::string& address);
// Likewise "finished": the program's work is done and it waits to be stopped.
void AnnounceFinished();

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SERVER_SERVER_H_
