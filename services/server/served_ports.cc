#include "services/server/served_ports.h"

#include <atomic>
#include <set>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::services {
namespace {

struct Ports {
  absl::Mutex mutex;
  std::set<const ServedPort*> served ABSL_GUARDED_BY(mutex);
  std::atomic<bool> takes_connections = true;
};

// It is never destroyed: servers may be.
Ports& AllPorts() {
  static Ports& ports = *new Ports;
  return ports;
}

}  // namespace

ServedPort::ServedPort(std::string port, std::function<ConnectionCounts()> count)
    : port_(std::move(port)), count_(std::move(count)) {
  absl::MutexLock lock(&AllPorts().mutex);
  AllPorts().served.insert(this);
}

ServedPort::~ServedPort() {
  absl::MutexLock lock(&AllPorts().mutex);
  AllPorts().served.erase(this);
}

std::vector<PortState> ServedPorts() {
  std::vector<PortState> states;
  absl::MutexLock lock(&AllPorts().mutex);
  for (const ServedPort* port : AllPorts().served) {
    states.push_back({port->port_, port->count_()});
  }
  return states;
}

void SetTakesConnections(bool takes) { AllPorts().takes_connections = takes; }

bool TakesConnections() { return AllPorts().takes_connections; }

}  // namespace corbslam::services
