// The way of a robot's batch into a mission: checked, journaled, applied, durable.
#ifndef CORBSLAM_MAP_STORE_MISSION_BATCH_INTAKE_H_
#define CORBSLAM_MAP_STORE_MISSION_BATCH_INTAKE_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/ingest/batch_application.h"
#include "map_store/mission/listeners.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/state/lookups.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Thread-safe.
class BatchIntake {
 public:
  // Not owned; must outlive it.
  BatchIntake(MissionStrand& strand, const Listeners& listeners)
      : strand_(strand), listeners_(listeners) {}

  // Once the batch is applied, others are told of it, also where the journal then can't make sure
  // of it: that is an error, without an acknowledgement, and the robot sends it again.
  absl::StatusOr<Acknowledgement> Apply(uint64_t session_id, const std::string& agent,
                                        const MapUpdateBatch& batch, const BatchTransfer* measured);

 private:
  // What to answer at once if the batch was applied before; none: it is the next one.
  using Known = std::optional<Acknowledgement>;

  absl::StatusOr<Known> Check(uint64_t session_id, const std::string& agent,
                              const MapUpdateBatch& batch) const
      ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  absl::StatusOr<Known> CheckAndValidate(uint64_t session_id, const std::string& agent,
                                         const MapUpdateBatch& batch) const;
  // RESOURCE_EXHAUSTED: the process has no memory for it.
  absl::Status CheckMemory(const MapUpdateBatch& batch) const;
  // Known: another one of the same session has applied it meanwhile.
  absl::StatusOr<Known> ApplyInTurn(uint64_t session_id, const std::string& agent,
                                    const MapUpdateBatch& batch, const BatchWords& words);
  absl::Status ApplyNext(const std::string& agent, const MapUpdateBatch& batch,
                         const BatchWords& words) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());

  MissionStrand& strand_;
  const Listeners& listeners_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_BATCH_INTAKE_H_
