// Makes the way of a simulation and the world around it.
#ifndef CORBSLAM_SLAM_SIMULATION_SEQUENCE_SIMULATED_WORLD_H_
#define CORBSLAM_SLAM_SIMULATION_SEQUENCE_SIMULATED_WORLD_H_

#include "absl/status/statusor.h"
#include "slam/simulation/motion/pose_sequence.h"
#include "slam/simulation/scene.h"
#include "slam/simulation/sequence/simulation_spec.h"

namespace corbslam {

// Returns the way as driven undisturbed, forwards. INVALID_ARGUMENT and NOT_FOUND are about the
// file of poses.
absl::StatusOr<PoseSequence> MakeWay(const SimulationSpec& spec);

// The world depends on the spec's options of world and way only, not on those of robot and
// pictures.
Scene BuildWorld(const SimulationSpec& spec, const PoseSequence& way);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_SEQUENCE_SIMULATED_WORLD_H_
