// "sim:WORLD?OPTIONS": sequences that are drawn when they are played. Lies outside client_agent/,
// so that a robot's program need not carry a simulator (docs/adr/0022-frame-streams.md).
#ifndef CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_SOURCE_H_
#define CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_SOURCE_H_

#include "client_agent/source/source_spec.h"
#include "slam/simulation/sequence/simulation_spec.h"

namespace corbslam {

// Before this program parses its first source. Any number of times, from any thread; true, so that
// a test may call it where it is loaded.
bool RegisterSimulatedSources();

// What `source` draws; null where it is no simulation. Lives as long as `source` is not changed.
const SimulationSpec* FindSimulation(const SourceSpec& source);

// `source`, which must be a simulation, draws `simulation` from now on.
void SetSimulation(const SimulationSpec& simulation, SourceSpec& source);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_SOURCE_H_
