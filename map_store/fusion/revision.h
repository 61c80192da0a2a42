// Commits a planned revision to the global layer: it only writes what was planned and prepared.
#ifndef CORBSLAM_MAP_STORE_FUSION_REVISION_H_
#define CORBSLAM_MAP_STORE_FUSION_REVISION_H_

#include "map_store/fusion/revision_layers.h"
#include "map_store/fusion/revision_plan.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Writes the plan and puts the layers in place; `layers` holds the old ones afterwards.
void CommitRevision(const RevisionPlan& plan, RevisionLayers& layers, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_REVISION_H_
