// Draws a map as messages of Foxglove: keyframes as frusta, their spanning tree, overlaps, points.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_SCENE_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_SCENE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/client/store/driven_way.h"
#include "services/client/store/told_map.h"
#include "services/tool/export/mcap/foxglove_channels.h"
#include "services/tool/export/robot_colours.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// An accepted overlap.
struct RecordedOverlap {
  KeyframeId query;
  KeyframeId candidate;
  uint64_t revision = 0;  // That took it into the graph; 0: none has, and it is not drawn.
};

using RobotColours = std::map<std::string, Colour>;

// A message with more points would be longer than 8 MB: the rest goes to topics of its own.
inline constexpr size_t kPointsInACloud = 500'000;

// Returns grey for a robot without a colour.
Colour ColourOf(const std::string& robot, const RobotColours& colours);

// Returns half of the usual distance from a keyframe to its parent, as the depth of frusta; nullopt
// where no keyframe has a parent at another place.
std::optional<double> ChooseFrustumDepth(const ToldMap& map);

// Each of these writes for every topic one message that holds all that is drawn on it, since a
// program that jumps to a time reads the last message before it.
absl::Status WriteKeyframes(const ToldMap& map, const RobotColours& colours, double frustum_depth,
                            uint64_t time_ns, FoxgloveChannels& channels);
// Draws what the map's revision has taken into its graph.
absl::Status WriteOverlaps(const ToldMap& map, const std::vector<RecordedOverlap>& overlaps,
                           uint64_t time_ns, FoxgloveChannels& channels);
// Draws the way that a robot drove in an island, cut where nothing connects two frames.
absl::Status WriteWay(const std::string& topic, LocalMapId island, const DrivenPath& way,
                      const Colour& colour, uint64_t time_ns, FoxgloveChannels& channels);
absl::Status WritePoints(const ToldMap& map, const RobotColours& colours, uint64_t time_ns,
                         FoxgloveChannels& channels);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_SCENE_H_
