// A world of flat textured cards at several depths, painted from the farthest to the nearest: what
// the checks need of pictures in a millisecond or two.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_LAYERED_SCENE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_LAYERED_SCENE_H_

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "client_agent/source_checks/testing/sample_source.h"

namespace corbslam::client_agent {

struct LayeredSceneOptions {
  uint64_t seed = 1;
  double moving = 1;    // Multiplies the camera's motion; 0: it stands still.
  double noise = 2;     // Standard deviation in grey levels, another draw in each picture.
  double contrast = 1;  // Multiplies the texture's contrast; 0: a bare wall.
  int farthest_px = 4;  // Disparity of the farthest card, the background.
  int nearest_px = 40;  // Disparity of the nearest card.
};

// 60 frames of 640 x 360 pixels; a rectified pair of baseline 0.1 m, or grey and depth in units of
// 0.2 mm. The camera moves to and fro, sideways and up and down, without turning.
SampleSource LayeredStereo(const LayeredSceneOptions& options = {});
SampleSource LayeredRgbd(const LayeredSceneOptions& options = {.farthest_px = 20});

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_LAYERED_SCENE_H_
