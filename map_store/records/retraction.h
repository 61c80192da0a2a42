// Takes back an accepted overlap, with all that followed from it.
#ifndef CORBSLAM_MAP_STORE_RECORDS_RETRACTION_H_
#define CORBSLAM_MAP_STORE_RECORDS_RETRACTION_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "map_store/options/options.h"
#include "map_store/records/journal_records.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns NOT_FOUND, or FAILED_PRECONDITION where the overlap was refused or taken back already.
absl::Status CheckRetractable(const MissionState& state, uint64_t overlap);

// Checks a retraction that is asked for now; records of older stores need not keep the last rule.
// Returns what CheckRetractable does, and FAILED_PRECONDITION where a local map would be kept apart
// from itself: no loop of it would ever be believed again.
absl::Status CheckRetraction(const MissionState& state, const RetractRecord& record);

// Takes the overlap out of the graph, as well as others between the same keyframes for ever (or
// between the same local maps, where the record says so). If it was in the graph, its island falls
// into its local maps, fusion's estimates of them, to all of which it may have led, are forgotten,
// and all other overlaps of the island wait to be fused again, also those that were refused because
// they contradicted the graph. Unless they are kept apart, the two local maps are looked up in one
// another again. Returns the numbers of the overlaps that were taken back.
std::vector<uint64_t> Retract(const RetractRecord& record, const MapStoreOptions& options,
                              MissionState& state);

// Returns the numbers of the live overlaps between two local maps, also between what were other
// local maps and are parts of them.
std::vector<uint64_t> FindLinks(const LocalMapState& a, const LocalMapState& b,
                                const OverlapLedger& overlaps);

// Returns whether somebody has taken back what the overlap says.
bool IsTakenBack(const Overlap& overlap, const MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_RETRACTION_H_
