// Finds what the rows of a pair say about its rig, beyond what the checks of every source find.
#ifndef CORBSLAM_SERVICES_TOOL_RIG_RIG_FINDINGS_H_
#define CORBSLAM_SERVICES_TOOL_RIG_RIG_FINDINGS_H_

#include <cstddef>

#include "client_agent/source/source_finding.h"
#include "services/tool/rig/pair_regions.h"

namespace corbslam::services {

// Fewer matches say nothing about a region's rows.
inline constexpr size_t kRegionMatches = 100;

// Returns how many regions have enough matches to be judged.
size_t JudgedRegions(const PairRegions& measured);

// Returns `pair-not-judged`, an error, where no pair could be judged (and `found`
// has no error that says why), and `lens-rows-apart` where
// rows are apart in a part of the pictures: what a wrong lens or focal length does. The latter not
// where `found` has another cause (pair-late, pair-exchanged); where it has pair-rows-apart,
// regions are held against what all have in common.
client_agent::SourceFindings FindingsOfRegions(const PairRegions& measured,
                                               const client_agent::SourceFindings& found);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RIG_RIG_FINDINGS_H_
