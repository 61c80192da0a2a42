// Spaces the shared updates of one stream, so that they take no more of the robot's link than it
// has asked for.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_SHARE_PACER_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_SHARE_PACER_H_

#include <cstddef>
#include <cstdint>
#include <optional>

#include "absl/time/time.h"
#include "slam/util/byte_bucket.h"

namespace corbslam::services {

// Says when the next update may go, and how large it may be. Waiting costs nothing: the next update
// is made when it may go, from the map as it is then. Not thread-safe.
class SharePacer {
 public:
  // 0: there is no bound.
  explicit SharePacer(uint64_t bytes_per_second = 0) : bucket_(bytes_per_second) {}

  // Returns how long the next update has to wait.
  absl::Duration Wait(absl::Time now);
  // Returns the most bytes of the next update, at most `most`; called once it need not wait.
  size_t Allow(size_t most, absl::Time now);
  // Notes an update of so many bytes (0: there was none). Returns for how long it has waited.
  absl::Duration NoteSent(size_t bytes, absl::Time now);

 private:
  ByteBucket bucket_;
  std::optional<absl::Time> waiting_since_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_SHARE_PACER_H_
