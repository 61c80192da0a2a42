// Tells metrics which ports this process serves, and how they are.
#ifndef CORBSLAM_SERVICES_SERVER_SERVED_PORTS_H_
#define CORBSLAM_SERVICES_SERVER_SERVED_PORTS_H_

#include <functional>
#include <string>
#include <vector>

#include "services/runtime/connection_book.h"

namespace corbslam::services {

struct PortState {
  std::string port;  // "grpc" or "web".
  ConnectionCounts connections;
};

// Is among ServedPorts as long as it lives. `count` is called by any thread.
class ServedPort {
 public:
  ServedPort(std::string port, std::function<ConnectionCounts()> count);
  ~ServedPort();
  ServedPort(const ServedPort&) = delete;
  ServedPort& operator=(const ServedPort&) = delete;

 private:
  friend std::vector<PortState> ServedPorts();

  const std::string port_;
  const std::function<ConnectionCounts()> count_;
};

// Returns the state of each port of this process. Thread-safe, as all of this.
std::vector<PortState> ServedPorts();

// Notes whether the process takes connections (services/server/self_watch.h); true at the start.
void SetTakesConnections(bool takes);
bool TakesConnections();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_SERVED_PORTS_H_
