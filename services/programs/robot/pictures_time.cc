#include "services/programs/robot/pictures_time.h"

namespace corbslam::services {

using client_agent::FrameStream;

double PicturesTime_s(const FrameStream& stream, size_t frames) {
  return static_cast<double>(frames) * stream.interval_s().value_or(0);
}

}  // namespace corbslam::services
