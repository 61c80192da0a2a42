// Opens a simulation, whose frames are drawn, not read.
#ifndef CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_READER_H_
#define CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_READER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "client_agent/source/frame_reader.h"
#include "services/simulation/sequence/simulation_spec.h"

namespace corbslam::services {

// Opens a reader. Errors of its Read are those of SimulatedSequence::Render, others those of
// SimulatedSequence::Make.
absl::StatusOr<std::unique_ptr<client_agent::FrameReader>> OpenSimulation(
    const SimulationSpec& spec);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SIMULATED_SOURCE_SIMULATED_READER_H_
