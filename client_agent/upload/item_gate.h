// Keeps back the items for which the map store would refuse a whole batch.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_ITEM_GATE_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_ITEM_GATE_H_

#include <cstdint>

#include "absl/status/status.h"

namespace corbslam::client_agent {

// Counts the items that were not let through. Not thread-safe.
class ItemGate {
 public:
  // Returns whether an item with this outcome of its check may be told. If not, it is counted and
  // logged (the first ones each, later ones now and then).
  bool Admit(const absl::Status& check);

  uint64_t refused() const { return refused_; }

 private:
  uint64_t refused_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_ITEM_GATE_H_
