// Computes how long a camera took for the pictures of a source.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_PICTURES_TIME_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_PICTURES_TIME_H_

#include <cstddef>

#include "client_agent/source/frame_stream.h"

namespace corbslam::services {

// Returns the seconds that the camera takes for `frames` frames at the interval of `stream`, so
// that pauses and several drives count by their frames alone. Returns 0 if the interval is not
// known.
double PicturesTime_s(const client_agent::FrameStream& stream, size_t frames);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_PICTURES_TIME_H_
