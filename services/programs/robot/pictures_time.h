// How long a camera took for the pictures of a source.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_PICTURES_TIME_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_PICTURES_TIME_H_

#include <cstddef>

#include "client_agent/source/image_source.h"

namespace corbslam {

// Seconds that the camera takes for `frames` frames at the pace of `source`: of its median
// interval, so that pauses and several drives count by their frames alone. 0 where the source has
// no two frames of one drive.
double PicturesTime_s(const ImageSource& source, size_t frames);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_PICTURES_TIME_H_
