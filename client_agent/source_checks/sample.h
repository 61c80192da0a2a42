// The frames of a source that its pictures are judged by.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SAMPLE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SAMPLE_H_

#include <cstddef>
#include <vector>

#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// One frame as the source recorded it: not perturbed, in the source's own numbering.
struct SampleFrame {
  size_t number = 0;
  SensorImages images;
};

// Frames are sorted by number, each once. Frames of neighbouring numbers show whether one picture
// of a frame belongs to another time; frames far apart show whether something holds for the whole
// source.
using Sample = std::vector<SampleFrame>;

struct SampleOptions {
  // Places are spread evenly from the first frame to the last.
  size_t places = 4;
  // Consecutive frames at each place.
  size_t stereo_row = 3;
  size_t rgbd_row = 5;
};

// Returns the numbers of the frames in [begin, end) to take as a sample, ascending: all of them
// where there are no more. A run takes the defaults; somebody who has a minute takes more places.
std::vector<size_t> ChooseSampleFrames(const SensorCalibration& calibration, size_t begin,
                                       size_t end, const SampleOptions& options = {});

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SAMPLE_H_
