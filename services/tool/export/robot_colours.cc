#include "services/tool/export/robot_colours.h"

#include "absl/strings/str_format.h"
#include "slam/rendering/paint.h"

namespace corbslam::services {

std::map<std::string, Colour> ChooseColours(const std::set<std::string>& robots) {
  std::map<std::string, Colour> colours;
  for (const auto& [robot, number] : NumberRobots(robots)) {
    const Paint& paint = SeriesPaint(number);
    colours[robot] = {paint.red, paint.green, paint.blue};
  }
  return colours;
}

std::string ToString(const Colour& colour) {
  return absl::StrFormat("#%02x%02x%02x", colour.red, colour.green, colour.blue);
}

}  // namespace corbslam::services
