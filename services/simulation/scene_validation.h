#ifndef CORBSLAM_SERVICES_SIMULATION_SCENE_VALIDATION_H_
#define CORBSLAM_SERVICES_SIMULATION_SCENE_VALIDATION_H_

#include "absl/status/status.h"
#include "services/simulation/scene.h"

namespace corbslam {

// INVALID_ARGUMENT names the field, for a mesh index out of range, a mover's path that is empty or
// goes back in time, a scale that isn't positive, or numbers that aren't finite.
absl::Status Validate(const Scene& scene);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SCENE_VALIDATION_H_
