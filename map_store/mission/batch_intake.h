// Takes a robot's batch into a mission: checked, journaled, applied, durable.
#ifndef CORBSLAM_MAP_STORE_MISSION_BATCH_INTAKE_H_
#define CORBSLAM_MAP_STORE_MISSION_BATCH_INTAKE_H_

#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/ingest/batch_application.h"
#include "map_store/mission/event_book.h"
#include "map_store/mission/listeners.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/state/lookups.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Applies the batches of all sessions of a mission. Thread-safe.
class BatchIntake {
 public:
  // The arguments are not owned and must outlive it.
  BatchIntake(MissionStrand& strand, const Listeners& listeners, EventBook& events)
      : strand_(strand), listeners_(listeners), events_(events) {}

  // Applies the batch, makes it durable and tells others of it. Others are told also where the
  // journal then can't make sure of it: that is an error, without an acknowledgement, and the robot
  // sends the batch again.
  absl::StatusOr<Acknowledgement> Apply(uint64_t session_id, const std::string& agent,
                                        const MapUpdateBatch& batch, const BatchTransfer* measured);

 private:
  // The answer to give at once to a batch that was applied before; nullopt: it is the next one.
  using Known = std::optional<Acknowledgement>;
  struct Applied {
    Known known;
    // With this batch the local map has its first keyframe.
    bool begins = false;
  };

  absl::StatusOr<Known> Check(uint64_t session_id, const std::string& agent,
                              const MapUpdateBatch& batch) const
      ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  absl::StatusOr<Known> CheckAndValidate(uint64_t session_id, const std::string& agent,
                                         const MapUpdateBatch& batch) const;
  // Makes what ApplyInTurn appends and applies; most of the journal's work is in it, so that others
  // don't wait for it. It must not outlive the batch, which is valid.
  BatchRecord MakeRecord(const std::string& agent, const MapUpdateBatch& batch) const;
  // Returns an acknowledgement if the same session has sent the batch twice and the other one was
  // applied meanwhile.
  absl::StatusOr<Applied> ApplyInTurn(uint64_t session_id, const BatchRecord& record,
                                      const BatchWords& words);
  void NoteEvents(const BatchRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());

  MissionStrand& strand_;
  const Listeners& listeners_;
  EventBook& events_;
  // Agents that said in their last batch that they had been lost.
  std::set<std::string> lost_ ABSL_GUARDED_BY(strand_.turn());
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_BATCH_INTAKE_H_
