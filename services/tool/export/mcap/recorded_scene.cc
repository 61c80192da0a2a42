#include "services/tool/export/mcap/recorded_scene.h"

#include <array>
#include <map>
#include <utility>

#include "foxglove/scene.pb.h"
#include "services/tool/export/mcap/foxglove_values.h"
#include "services/tool/export/mcap/frame_names.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr Colour kUnknownRobot = {128, 128, 128};
constexpr Colour kOverlap = {255, 96, 0};
constexpr double kTreeOpacity = 0.5;
constexpr double kLine_px = 1.5;
constexpr double kOverlapLine_px = 2.5;

// Corners of a picture at depth 1, and the apex before them; which of them lines connect. The store
// tells no keyframe's camera, so that all are drawn alike.
const std::array<Eigen::Vector3d, 5> kFrustum = {
    {{0, 0, 0}, {-0.5, -0.375, 1}, {0.5, -0.375, 1}, {0.5, 0.375, 1}, {-0.5, 0.375, 1}}};
constexpr std::array<uint32_t, 16> kFrustumLines = {0, 1, 0, 2, 0, 3, 0, 4, 1, 2, 2, 3, 3, 4, 4, 1};

using Entities = std::map<std::string, foxglove::SceneUpdate>;  // By topic.

foxglove::SceneUpdate BeginUpdate(uint64_t time_ns) {
  foxglove::SceneUpdate update;
  foxglove::SceneEntityDeletion* deletion = update.add_deletions();
  ToFoxglove(time_ns, deletion->mutable_timestamp());
  deletion->set_type(foxglove::SceneEntityDeletion::ALL);
  return update;
}

foxglove::SceneEntity* AddEntity(LocalMapId island, uint64_t time_ns,
                                 foxglove::SceneUpdate& update) {
  foxglove::SceneEntity* entity = update.add_entities();
  ToFoxglove(time_ns, entity->mutable_timestamp());
  entity->set_frame_id(IslandFrame(island));
  entity->set_id(IslandFrame(island));
  entity->set_frame_locked(true);
  return entity;
}

foxglove::LinePrimitive* AddLines(foxglove::LinePrimitive::Type type, double width_px,
                                  foxglove::SceneEntity& entity) {
  foxglove::LinePrimitive* lines = entity.add_lines();
  lines->set_type(type);
  lines->set_thickness(width_px);
  lines->set_scale_invariant(true);
  ToFoxglove(Rigid3d::Identity(), lines->mutable_pose());
  return lines;
}

// Returns the lines of a new entity in the island's frame.
foxglove::LinePrimitive* AddLines(LocalMapId island, uint64_t time_ns, double width_px,
                                  foxglove::SceneUpdate& update) {
  return AddLines(foxglove::LinePrimitive::LINE_LIST, width_px,
                  *AddEntity(island, time_ns, update));
}

void AddFrustum(const Rigid3d& island_from_camera, double depth, foxglove::LinePrimitive& lines) {
  const auto first = static_cast<uint32_t>(lines.points_size());
  for (const Eigen::Vector3d& corner : kFrustum) {
    ToFoxglove(island_from_camera * (depth * corner), lines.add_points());
  }
  for (const uint32_t index : kFrustumLines) lines.add_indices(first + index);
}

void AddLine(const ToldMap::Keyframe& from, const ToldMap::Keyframe& to,
             foxglove::LinePrimitive& lines) {
  ToFoxglove(from.island_from_camera.translation, lines.add_points());
  ToFoxglove(to.island_from_camera.translation, lines.add_points());
}

const ToldMap::Keyframe* Find(KeyframeId id, const ToldMap::Island& island) {
  const auto found = island.keyframes.find(id);
  return found == island.keyframes.end() ? nullptr : &found->second;
}

// Returns how far the robot usually went from one keyframe of a local map to the next.
std::map<LocalMapId, double> UsualSteps(const ToldMap::Island& island) {
  std::map<LocalMapId, std::map<KeyframeId, Rigid3d>> poses;
  for (const auto& [id, keyframe] : island.keyframes) {
    poses[id.local_map][id] = keyframe.island_from_camera;
  }
  std::map<LocalMapId, double> steps;
  for (const auto& [local_map, own] : poses) steps[local_map] = UsualStep(own);
  return steps;
}

// The lines of one robot in one island.
struct RobotLines {
  foxglove::LinePrimitive* frusta = nullptr;
  foxglove::LinePrimitive* tree = nullptr;
};

class KeyframeDrawing {
 public:
  KeyframeDrawing(const ToldMap& map, const RobotColours& colours, double depth, uint64_t time_ns)
      : map_(map), colours_(colours), depth_(depth), time_ns_(time_ns) {
    // A robot that has no keyframe any more keeps none on its topics.
    for (const auto& [robot, colour] : colours) BeginRobot(robot);
    for (const auto& [local_map, robot] : map.agents) BeginRobot(robot);
  }

  Entities Draw() && {
    for (const auto& [id, island] : map_.islands) DrawIsland(id, island);
    return std::move(updates_);
  }

 private:
  void BeginRobot(const std::string& robot) {
    for (const char* what : {"keyframes", "tree"}) {
      updates_.try_emplace(MapTopic(robot, what), BeginUpdate(time_ns_));
    }
  }

  RobotLines BeginLines(LocalMapId island, const std::string& robot) {
    BeginRobot(robot);
    RobotLines lines;
    lines.frusta = AddLines(island, time_ns_, kLine_px, updates_[MapTopic(robot, "keyframes")]);
    lines.tree = AddLines(island, time_ns_, kLine_px, updates_[MapTopic(robot, "tree")]);
    const Colour colour = ColourOf(robot, colours_);
    ToFoxglove(colour, 1, lines.frusta->mutable_color());
    ToFoxglove(colour, kTreeOpacity, lines.tree->mutable_color());
    return lines;
  }

  void DrawIsland(LocalMapId id, const ToldMap::Island& island) {
    std::map<std::string, RobotLines> robots;
    const std::map<LocalMapId, double> usual_steps = UsualSteps(island);
    for (const auto& [keyframe_id, keyframe] : island.keyframes) {
      const std::string robot = map_.AgentOf(keyframe_id.local_map);
      const auto [lines, is_new] = robots.try_emplace(robot);
      if (is_new) lines->second = BeginLines(id, robot);
      AddFrustum(keyframe.island_from_camera, depth_, *lines->second.frusta);
      const ToldMap::Keyframe* parent = Find(keyframe.parent, island);
      if (parent != nullptr && !IsGap(parent->island_from_camera, keyframe.island_from_camera,
                                      usual_steps.at(keyframe_id.local_map))) {
        AddLine(keyframe, *parent, *lines->second.tree);
      }
    }
  }

  const ToldMap& map_;
  const RobotColours& colours_;
  const double depth_;
  const uint64_t time_ns_;
  Entities updates_;
};

}  // namespace

absl::Status WriteWay(const std::string& topic, LocalMapId island, const DrivenPath& way,
                      const Colour& colour, uint64_t time_ns, FoxgloveChannels& channels) {
  foxglove::SceneUpdate update = BeginUpdate(time_ns);
  foxglove::SceneEntity* entity = AddEntity(island, time_ns, update);
  for (const std::vector<Eigen::Vector3d>& piece : way) {
    foxglove::LinePrimitive* line =
        AddLines(foxglove::LinePrimitive::LINE_STRIP, kLine_px, *entity);
    ToFoxglove(colour, 1, line->mutable_color());
    for (const Eigen::Vector3d& place : piece) ToFoxglove(place, line->add_points());
  }
  return channels.Write(topic, time_ns, update);
}

Colour ColourOf(const std::string& robot, const RobotColours& colours) {
  const auto colour = colours.find(robot);
  return colour == colours.end() ? kUnknownRobot : colour->second;
}

std::optional<double> ChooseFrustumDepth(const ToldMap& map) {
  std::vector<double> distances;
  for (const auto& [island_id, island] : map.islands) {
    for (const auto& [id, keyframe] : island.keyframes) {
      const ToldMap::Keyframe* parent = Find(keyframe.parent, island);
      if (parent == nullptr) continue;
      const double distance =
          (keyframe.island_from_camera.translation - parent->island_from_camera.translation).norm();
      if (distance > 0) distances.push_back(distance);
    }
  }
  if (distances.empty()) return std::nullopt;
  return 0.5 * Median(distances);
}

absl::Status WriteKeyframes(const ToldMap& map, const RobotColours& colours, double frustum_depth,
                            uint64_t time_ns, FoxgloveChannels& channels) {
  for (const auto& [topic, update] : KeyframeDrawing(map, colours, frustum_depth, time_ns).Draw()) {
    RETURN_IF_ERROR(channels.Write(topic, time_ns, update));
  }
  return absl::OkStatus();
}

absl::Status WriteOverlaps(const ToldMap& map, const std::vector<RecordedOverlap>& overlaps,
                           uint64_t time_ns, FoxgloveChannels& channels) {
  foxglove::SceneUpdate update = BeginUpdate(time_ns);
  for (const auto& [id, island] : map.islands) {
    foxglove::LinePrimitive* lines = nullptr;
    for (const RecordedOverlap& overlap : overlaps) {
      if (overlap.revision == 0 || overlap.revision > map.revision) continue;
      const ToldMap::Keyframe* query = Find(overlap.query, island);
      const ToldMap::Keyframe* candidate = Find(overlap.candidate, island);
      if (query == nullptr || candidate == nullptr) continue;
      if (lines == nullptr) lines = AddLines(id, time_ns, kOverlapLine_px, update);
      AddLine(*query, *candidate, *lines);
    }
    if (lines != nullptr) ToFoxglove(kOverlap, 1, lines->mutable_color());
  }
  return channels.Write("/map/overlaps", time_ns, update);
}

}  // namespace corbslam::services
