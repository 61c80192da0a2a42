// Makes a way to a server that can fall silent: connections stay, and nothing comes through.
#ifndef CORBSLAM_SERVICES_TESTING_SILENT_PROXY_H_
#define CORBSLAM_SERVICES_TESTING_SILENT_PROXY_H_

#include <atomic>
#include <list>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/statusor.h"

namespace corbslam::services {

// Carries TCP between its clients and one server on the loopback device. Thread-safe.
class SilentProxy {
 public:
  // Starts a proxy to "127.0.0.1:PORT". UNAVAILABLE with the system's reason.
  static absl::StatusOr<std::unique_ptr<SilentProxy>> Start(const std::string& server);
  ~SilentProxy();
  SilentProxy(const SilentProxy&) = delete;
  SilentProxy& operator=(const SilentProxy&) = delete;

  const std::string& address() const { return address_; }

  // Sets whether the proxy is silent. What comes while it is silent is never carried, not later
  // either: a connection that has lost bytes so is dead for both sides, and neither is told. New
  // connections are accepted, and are as silent.
  void SetSilent(bool silent) { silent_ = silent; }

 private:
  struct Connection {
    int client = -1;
    int server = -1;
    std::atomic<bool> dead{false};
    std::thread up;
    std::thread down;
  };

  SilentProxy(int listening, int own_port, int server_port);
  void Accept();
  void Carry(int from, int to, std::atomic<bool>& dead);

  const int listening_;
  const int server_port_;
  const std::string address_;
  std::atomic<bool> silent_{false};
  std::list<Connection> connections_;  // The accepting thread uses them, then the destructor.
  std::thread accepting_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TESTING_SILENT_PROXY_H_
