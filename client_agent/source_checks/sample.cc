#include "client_agent/source_checks/sample.h"

#include <algorithm>
#include <set>

namespace corbslam::client_agent {

std::vector<size_t> ChooseSampleFrames(const SensorCalibration& calibration, size_t begin,
                                       size_t end, const SampleOptions& options) {
  if (begin >= end) return {};
  const size_t count = end - begin;
  const size_t row = std::min(
      count, KindOf(calibration) == SensorKind::kRgbd ? options.rgbd_row : options.stereo_row);
  const size_t places = std::max<size_t>(options.places, 1);
  std::set<size_t> chosen;
  for (size_t place = 0; place < places; ++place) {
    const size_t first = begin + (places == 1 ? 0 : place * (count - row) / (places - 1));
    for (size_t i = 0; i < row; ++i) chosen.insert(first + i);
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace corbslam::client_agent
