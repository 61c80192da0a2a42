// What a robot has mapped that is in no batch yet, as its spool keeps it: mapping may yet take
// keyframes out, or a link's budget has no room, but a process that is killed must not lose them.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_ITEMS_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_ITEMS_H_

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client_agent/spool/spool.h"
#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

struct HeldItems {
  // Payloads that were not here before.
  std::vector<FullKeyframe> keyframes;
  // All that is held: keyframes as light ones, full points, observations, frames. It fits what was
  // told in batches, as the next one would.
  MapUpdateBatch rest;
};

// Writes what one local map holds back to a spool, in place of what it held before. Not
// thread-safe.
class HeldWriter {
 public:
  // `last_batch` is the number of the last batch before, at least 1.
  absl::Status Write(const HeldItems& held, uint64_t last_batch, Spool& spool);
  // It is all in batches that the spool has; goes once these outlive a loss of power.
  void Finish(Spool& spool);
  // Gives room back at once.
  void Release(Spool& spool);

 private:
  std::map<KeyframeId, SpooledBatch> keyframes_;
  std::vector<SpooledBatch> rest_;
};

// Makes batches of what an earlier process held back when it ended, and puts them behind what the
// spool found, but for what later batches told. After an error (the disk has no room,
// fails, or has not kept it) some of it is lost.
absl::Status TellHeld(Spool& spool);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_ITEMS_H_
