// Chooses a colour for each robot, the same in every export of a mission.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_ROBOT_COLOURS_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_ROBOT_COLOURS_H_

#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace corbslam::services {

struct Colour {
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

// Returns the robots' colours by name: those that the viewer's page and plots give them.
std::map<std::string, Colour> ChooseColours(const std::set<std::string>& robots);

// Returns a text as "#1f77b4".
std::string ToString(const Colour& colour);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_ROBOT_COLOURS_H_
