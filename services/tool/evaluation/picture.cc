#include "services/tool/evaluation/picture.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace corbslam::services {
namespace {

constexpr size_t kMostPathPoints = 8'000;

// Returns at most so many places of a piece of a path, its ends among them.
std::vector<Eigen::Vector3d> Thin(const std::vector<Eigen::Vector3d>& piece) {
  const size_t stride = (piece.size() + kMostPathPoints - 1) / kMostPathPoints;
  std::vector<Eigen::Vector3d> thin;
  for (size_t i = 0; i < piece.size(); i += stride) thin.push_back(piece[i]);
  if (stride > 1) thin.push_back(piece.back());
  return thin;
}

// What of a keyframe is needed to join it with others.
struct Joint {
  std::string agent;
  Rigid3d pose;
};

// Adds edges to parents of the same robot, where a line stands for the way; of robots whose path is
// known as driven, none.
void AddEdges(const ServedMap& map, const DrivenPaths& driven,
              const std::map<KeyframeId, size_t>& index_of,
              std::map<std::string, MapPicture::Robot>& robots) {
  std::map<KeyframeId, Joint> joints;
  std::map<std::string, std::map<KeyframeId, Rigid3d>> poses;
  for (const ServedMap::Keyframe& keyframe : map.keyframes) {
    joints[keyframe.id] = {keyframe.agent, keyframe.global_from_camera};
    poses[keyframe.agent][keyframe.id] = keyframe.global_from_camera;
  }
  std::map<std::string, double> usual_step;
  for (const auto& [agent, own] : poses) usual_step[agent] = UsualStep(own);
  for (const ServedMap::Keyframe& keyframe : map.keyframes) {
    const auto path = driven.find(keyframe.agent);
    if (path != driven.end() && !path->second.empty()) continue;
    const auto parent = joints.find(keyframe.parent);
    if (parent == joints.end() || parent->second.agent != keyframe.agent) continue;
    if (IsGap(parent->second.pose, keyframe.global_from_camera, usual_step[keyframe.agent])) {
      continue;
    }
    robots[keyframe.agent].edges.push_back(
        {index_of.at(keyframe.parent), index_of.at(keyframe.id)});
  }
}

// Returns the robots by name, with their paths, or with edges to parents of the same robot.
std::vector<MapPicture::Robot> GroupByRobot(const ServedMap& map, const std::string& own,
                                            const DrivenPaths& driven) {
  std::map<std::string, MapPicture::Robot> robots;
  std::map<KeyframeId, size_t> index_of;  // Index of a keyframe within its robot.
  for (const ServedMap::Keyframe& keyframe : map.keyframes) {
    MapPicture::Robot& robot = robots[keyframe.agent];
    robot.name = keyframe.agent;
    robot.is_own = keyframe.agent == own;
    index_of[keyframe.id] = robot.keyframes.size();
    robot.keyframes.push_back(keyframe.global_from_camera);
  }
  AddEdges(map, driven, index_of, robots);
  for (const auto& [name, path] : driven) {
    if (path.empty()) continue;
    MapPicture::Robot& robot = robots[name];
    robot.name = name;
    robot.is_own = name == own;
    for (const std::vector<Eigen::Vector3d>& piece : path) robot.paths.push_back(Thin(piece));
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

DrivenPaths DrivenOf(const std::vector<RobotPaths>& robots) {
  DrivenPaths driven;
  for (const RobotPaths& robot : robots) driven[robot.name] = PiecesOf(robot.global);
  return driven;
}

MapPicture ComposePicture(const ServedMap& map, const std::string& own,
                          const FusedAccuracy& accuracy, const DrivenPaths& driven) {
  MapPicture picture;
  picture.robots = GroupByRobot(map, own, driven);
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
