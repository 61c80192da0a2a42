// Joins points that neighbouring keyframes hold twice, and adds observations that were missed.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_POINT_FUSION_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_POINT_FUSION_H_

#include "absl/types/span.h"
#include "client_agent/map/guarded_map.h"
#include "slam/matching/fuse_matching.h"

namespace corbslam::client_agent {

// Projects the keyframe's points into its neighbours (ten, and five of each of theirs) and theirs
// into it (ORB-SLAM, T-RO 2015, VI.C). Others' keyframes are not given observations; where an own
// and a foreign point are one, the foreign one survives. Mapping thread only; writes.
void FuseNeighbours(KeyframeId keyframe, GuardedMap& map);

// Applies proposals for an own keyframe: it adds observations, and where two points are one, the
// one that more keyframes see survives. Proposals that are out of date are skipped.
void ApplyFuseProposals(KeyframeId keyframe, absl::Span<const FuseProposal> proposals,
                        LocalMapId own, Map& map);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_POINT_FUSION_H_
