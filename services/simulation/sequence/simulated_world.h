// Makes the way of a simulation and the world around it.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATED_WORLD_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATED_WORLD_H_

#include "absl/status/statusor.h"
#include "services/simulation/motion/pose_sequence.h"
#include "services/simulation/scene.h"
#include "services/simulation/sequence/simulation_spec.h"

namespace corbslam {

// Returns the way as driven undisturbed, forwards. INVALID_ARGUMENT and NOT_FOUND are about the
// file of poses.
absl::StatusOr<PoseSequence> MakeWay(const SimulationSpec& spec);

// The world depends on the spec's options of world and way only, not on those of robot and
// pictures.
Scene BuildWorld(const SimulationSpec& spec, const PoseSequence& way);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATED_WORLD_H_
