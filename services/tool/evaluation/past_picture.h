// Composes pictures of a mission's past.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_PAST_PICTURE_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_PAST_PICTURE_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/client/store/told_map.h"
#include "services/tool/evaluation/accuracy.h"
#include "slam/rendering/map_snapshots.h"

namespace corbslam::services {

// Returns all islands of the moment; the truth, where there is one, lies in the global frame as
// that is now. Local maps whose agent was not told are drawn as others'.
MapSnapshot ComposeSnapshot(const ToldMap& past, const std::string& own,
                            const FusedAccuracy& accuracy);

// Calls `use` with the map of every told moment, in order, and its number among them (from 0).
absl::Status ForEachMoment(const std::vector<v1::WatchMapResponse>& past,
                           const std::function<absl::Status(size_t, const ToldMap&)>& use);

// Returns the revision of each told moment, in order.
std::vector<uint64_t> RevisionsOf(const std::vector<v1::WatchMapResponse>& past);

// Reads which of the told moments are meant, whose revisions are `told`. "25%": that share of the
// way through them, "0%" the first; "17": the last one of that revision, or where it is not told of
// one before it. Returns their numbers in `told`, in the order of the text. INVALID_ARGUMENT names
// what can't be read, and the revisions there are.
absl::StatusOr<std::vector<size_t>> ParseMoments(const std::string& text,
                                                 const std::vector<uint64_t>& told);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_PAST_PICTURE_H_
