#include "services/tool/export/robot_colours.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"

namespace corbslam::services {
namespace {

// Returns one channel, whose peak lies at `peak` turns of hue; it is not so bright that it is lost
// on white.
uint8_t Channel(double hue, double peak) {
  const double distance = std::abs(std::remainder(hue - peak, 1.0));
  return static_cast<uint8_t>(std::lround(200.0 * std::clamp(2.0 - 6.0 * distance, 0.0, 1.0)));
}

}  // namespace

std::map<std::string, Colour> ChooseColours(const std::set<std::string>& robots) {
  // Multiples of the golden ratio stay apart, however many there are.
  constexpr double kGoldenRatio = 0.6180339887498949;
  std::map<std::string, Colour> colours;
  double hue = 1.0 / 3;
  for (const std::string& robot : robots) {
    colours[robot] = {Channel(hue, 0), Channel(hue, 1.0 / 3), Channel(hue, 2.0 / 3)};
    hue = std::fmod(hue + kGoldenRatio, 1.0);
  }
  return colours;
}

std::string ToString(const Colour& colour) {
  return absl::StrFormat("#%02x%02x%02x", colour.red, colour.green, colour.blue);
}

}  // namespace corbslam::services
