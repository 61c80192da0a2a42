// Options of a simulation that say what happens to its pictures, and when.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_EVENT_OPTIONS_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_EVENT_OPTIONS_H_

#include <vector>

#include "services/simulation/sequence/option_kinds.h"

namespace corbslam {

std::vector<SimulationOption> EventOptions();

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_EVENT_OPTIONS_H_
