#include "client_agent/upload/item_gate.h"

#include <glog/logging.h>

namespace corbslam::client_agent {
namespace {

// A solver that diverges spoils thousands of items at once.
constexpr uint64_t kLoggedEach = 20;
constexpr uint64_t kLoggedEvery = 1000;

}  // namespace

bool ItemGate::Admit(const absl::Status& check) {
  if (check.ok()) return true;
  ++refused_;
  if (refused_ <= kLoggedEach || refused_ % kLoggedEvery == 0) {
    LOG(ERROR) << "not told to the map store, which would refuse it (item " << refused_
               << " of this local map): " << check.message();
  }
  return false;
}

}  // namespace corbslam::client_agent
