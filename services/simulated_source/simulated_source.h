// Registers "sim:WORLD?OPTIONS": sequences drawn when they are played. It lies outside
// client_agent/, so that a robot's program need not carry a simulator
// (docs/adr/0022-frame-streams.md).
#ifndef CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_SOURCE_H_
#define CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_SOURCE_H_

#include "client_agent/source/source_spec.h"
#include "services/simulation/sequence/simulation_spec.h"

namespace corbslam::services {

// Registers the kind of source, before the program parses its first one; any thread may call it
// again. Returns true, so that a test may call it where it is loaded.
bool RegisterSimulatedSources();

// Returns what `source` draws; null if it is no simulation. The result lives as long as `source` is
// not changed.
const SimulationSpec* FindSimulation(const client_agent::SourceSpec& source);

// Makes `source`, which must be a simulation, draw `simulation` from now on.
void SetSimulation(const SimulationSpec& simulation, client_agent::SourceSpec& source);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_SOURCE_H_
