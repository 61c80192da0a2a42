// Names the frames and topics of a recording. What others say is escaped: every byte that is no
// ASCII letter, digit, dot, dash or underscore becomes %XX, so that different names stay different
// and none is taken for a path.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FRAME_NAMES_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FRAME_NAMES_H_

#include <cstddef>
#include <string>

#include "absl/strings/string_view.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// The mission's global frame, and above it one whose z points up where the first camera was level.
inline constexpr char kMissionFrame[] = "mission";
inline constexpr char kUprightFrame[] = "upright";

// Returns "%" for an empty name.
std::string EscapeName(absl::string_view name);
// Returns a text in which only bytes that are not printable ASCII are escaped.
std::string EscapeText(absl::string_view text);

// Returns "island/00c0ffee00c0ffee".
std::string IslandFrame(LocalMapId island);
// Returns "/map/alpha/keyframes".
std::string MapTopic(absl::string_view robot, absl::string_view what);
// Returns "/robots/alpha/pose".
std::string RobotTopic(absl::string_view robot, absl::string_view what);

// Returns "", or "+2" for number 2 and so on: no escaped name has a '+'.
std::string NumberSuffix(size_t number);
// Returns "" in the global frame, otherwise "/" and the island's id.
std::string IslandSuffix(LocalMapId island, bool in_global_frame);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FRAME_NAMES_H_
