#include "services/tool/evaluation/picture.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace corbslam::services {
namespace {

// Returns the robots by name, with edges to parents of the same robot.
std::vector<MapPicture::Robot> GroupByRobot(const ServedMap& map, const std::string& own) {
  std::map<std::string, MapPicture::Robot> robots;
  std::map<KeyframeId, size_t> index_of;  // Index of a keyframe within its robot.
  for (const ServedMap::Keyframe& keyframe : map.keyframes) {
    MapPicture::Robot& robot = robots[keyframe.agent];
    robot.name = keyframe.agent;
    robot.is_own = keyframe.agent == own;
    index_of[keyframe.id] = robot.keyframes.size();
    robot.keyframes.push_back(keyframe.global_from_camera);
  }
  std::map<KeyframeId, std::string> agent_of;
  for (const ServedMap::Keyframe& keyframe : map.keyframes) {
    agent_of[keyframe.id] = keyframe.agent;
  }
  for (const ServedMap::Keyframe& keyframe : map.keyframes) {
    const auto parent = agent_of.find(keyframe.parent);
    if (parent == agent_of.end() || parent->second != keyframe.agent) continue;
    robots[keyframe.agent].edges.push_back({index_of[keyframe.parent], index_of[keyframe.id]});
  }
  std::vector<MapPicture::Robot> list;
  for (auto& [name, robot] : robots) list.push_back(std::move(robot));
  return list;
}

}  // namespace

absl::StatusOr<std::string> ChooseOwn(const std::string& wanted,
                                      const std::vector<std::string>& robots) {
  if (robots.empty()) return absl::InvalidArgumentError("there are no robots");
  if (wanted.empty()) return robots.front();
  if (std::find(robots.begin(), robots.end(), wanted) != robots.end()) return wanted;
  return absl::InvalidArgumentError(
      absl::StrCat("--own ", wanted, ": no robot is called so, but ", absl::StrJoin(robots, ", ")));
}

MapPicture ComposePicture(const ServedMap& map, const std::string& own,
                          const FusedAccuracy& accuracy) {
  MapPicture picture;
  picture.robots = GroupByRobot(map, own);
  picture.points = map.points;
  picture.title = absl::StrCat("Global map of ", picture.robots.size(),
                               picture.robots.size() == 1 ? " robot" : " robots");
  if (accuracy.all.has_value()) {
    absl::StrAppend(&picture.title, absl::StrFormat(": fused ATE %.3f m", accuracy.all->rmse_m));
  }
  if (map.elsewhere.islands > 0) {
    picture.note = absl::StrCat("not drawn, since nothing connects it with this map: ",
                                Describe(map.elsewhere));
  }
  if (accuracy.truth.has_value() && accuracy.truth_from_global.has_value()) {
    std::vector<Eigen::Vector3d>& path = picture.truth.emplace_back();
    const Similarity3d global_from_truth = accuracy.truth_from_global->Inverse();
    for (const StampedPose& pose : *accuracy.truth) {
      path.push_back(global_from_truth * pose.world_from_camera.translation);
    }
  }
  return picture;
}

}  // namespace corbslam::services
