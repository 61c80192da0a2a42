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

// Calls `use` with the map of every told revision, in order, and its number among them (from 0).
absl::Status ForEachRevision(const std::vector<v1::WatchMapResponse>& past,
                             const std::function<absl::Status(size_t, const ToldMap&)>& use);

// Returns the revisions that are told, in order.
std::vector<uint64_t> ToldRevisions(const std::vector<v1::WatchMapResponse>& past);

// Moments, of which `told` revisions there are. "25%": that share of the way through them, "0%" the
// first; "17": that revision, or where it is not told the last before it. Returns their numbers in
// `told`, in the order of the text. INVALID_ARGUMENT names what can't be read, and the revisions
// there are.
absl::StatusOr<std::vector<size_t>> ParseMoments(const std::string& text,
                                                 const std::vector<uint64_t>& told);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_PAST_PICTURE_H_
