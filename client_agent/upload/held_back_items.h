// What a robot has mapped that is in no batch yet, as its spool keeps it: mapping may yet take
// keyframes out, or a link's budget has no room, but a process that is killed must not lose them.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_ITEMS_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_ITEMS_H_

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client_agent/spool/spool.h"
#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

struct HeldBackItems {
  // Payloads that were not here before.
  std::vector<FullKeyframe> keyframes;
  // All that is held back: keyframes as light ones, full points, observations, frames. It fits what
  // was told in batches, as the next one would.
  MapUpdateBatch rest;
};

// Writes what one local map holds back to a spool, in place of what it held back before. Not
// thread-safe.
class HeldBackWriter {
 public:
  // `last_batch` is the number of the last batch before, at least 1.
  absl::Status Write(const HeldBackItems& held_back, uint64_t last_batch, Spool& spool);
  // Notes that all of it is in batches that the spool has; it goes once these outlive a loss of
  // power.
  void Finish(Spool& spool);
  // Gives the room in the spool back at once.
  void Release(Spool& spool);

 private:
  std::map<KeyframeId, SpooledBatch> keyframes_;
  std::vector<SpooledBatch> rest_;
};

// Makes batches of what an earlier process held back when it ended, and puts them behind what the
// spool found, but for what later batches told. After an error (the disk has no room,
// fails, or has not kept it) some of it is lost.
absl::Status TellHeldBack(Spool& spool);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_ITEMS_H_
