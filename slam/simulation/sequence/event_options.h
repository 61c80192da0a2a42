// Options of a simulation that say what happens to its pictures, and when.
#ifndef CORBSLAM_SLAM_SIMULATION_SEQUENCE_EVENT_OPTIONS_H_
#define CORBSLAM_SLAM_SIMULATION_SEQUENCE_EVENT_OPTIONS_H_

#include <vector>

#include "slam/simulation/sequence/option_kinds.h"

namespace corbslam {

std::vector<SimulationOption> EventOptions();

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_SEQUENCE_EVENT_OPTIONS_H_
