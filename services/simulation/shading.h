// Computes the light that comes to the eye from what is seen.
#ifndef CORBSLAM_SERVICES_SIMULATION_SHADING_H_
#define CORBSLAM_SERVICES_SIMULATION_SHADING_H_

#include <opencv2/core/mat.hpp>

#include "services/simulation/scene_faces.h"

namespace corbslam {

// Returns light as CV_32FC1 of the camera's size; 1 is a white surface in full sun. Where several
// faces lie within a pixel it is the mean over the samples; a face is shaded once a pixel.
// `threads` changes speed only.
cv::Mat ComputeLight(const SceneFaces& scene, const SceneView& view, int threads);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SHADING_H_
