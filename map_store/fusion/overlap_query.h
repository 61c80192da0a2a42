// Leads from a settled keyframe to the request that verifies what its words suggest.
#ifndef CORBSLAM_MAP_STORE_FUSION_OVERLAP_QUERY_H_
#define CORBSLAM_MAP_STORE_FUSION_OVERLAP_QUERY_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::map_store {

// What a keyframe finds in one local map.
struct FoundPlaces {
  std::vector<VerifyOverlapRequest::Candidate> candidates;  // Best first.
  double likeness = 0;   // Of the keyframe that looks most like the query: 0 to 1, by words.
  bool is_seam = false;  // True: the robot may go on here where its local map before ended.
  // True: the two are linked already, by an accepted overlap close by, or by landmarks that both
  // see where the global layer has them.
  bool are_linked = false;
};

// What a keyframe's words find in one local map; nobody has asked yet whether it is news.
struct Resemblance {
  double likeness = 0;   // As FoundPlaces.
  bool is_seam = false;  // The same, if it is news.
};
Resemblance FindResemblance(const MissionState& state, const QueryTask& task,
                            const MapStoreOptions& options);

// Returns whether there is an accepted overlap, in the graph or waiting for it, of the query
// itself, or of a keyframe within `options.overlap_spacing` of it, with `task.against`. It costs
// what there are overlaps close by, not in the local maps.
bool HasOverlapNearby(const MissionState& state, const QueryTask& task,
                      const MapStoreOptions& options);

// Finds keyframes of `task.against` that may show the query's place, best first: settled ones
// that share enough words, the best of each of the best groups of covisible keyframes; first of
// all, for the first keyframes of a robot's local map, the last one of its local map before. There
// are none where the two are linked already, or where nobody would call it a loop (near the query
// in its own local map).
FoundPlaces FindCandidates(const MissionState& state, const QueryTask& task,
                           const MapStoreOptions& options);

// Keeps the view around the query that was built last: a keyframe is held against one local map
// after the other, and its view is the same as long as nothing changes. Of one mission; not
// thread-safe.
class QueryViews {
 public:
  // Returns what BuildPartialView does.
  absl::StatusOr<std::shared_ptr<const Map>> ViewAround(const std::set<KeyframeId>& keyframes,
                                                        const MissionState& state, LongRead& read);
  void Clear() { view_.reset(); }

 private:
  uint64_t version_ = 0;
  std::set<KeyframeId> keyframes_;
  std::shared_ptr<const Map> view_;
};

// Returns both sides with the keyframes around them, in their islands' frames; nullopt when there
// are no candidates. ABORTED: as `read` says, or the owner removed one of the keyframes meanwhile.
absl::StatusOr<std::optional<VerifyOverlapRequest>> BuildVerifyRequest(
    const MissionState& state, const QueryTask& task, const MapStoreOptions& options,
    LongRead& read, QueryViews& views);

// Returns whether both local maps have a metric scale of their own.
bool BothMetric(const LocalMapState& a, const LocalMapState& b);

// Returns by how many pixels the overlap disagrees with where the two keyframes stand now; both
// must be in one island.
double GraphResidualPx(const MissionState& state, const Overlap& overlap);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_OVERLAP_QUERY_H_
