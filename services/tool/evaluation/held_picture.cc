#include "services/tool/evaluation/held_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/client/store/driven_way.h"

namespace corbslam::services {

using client_agent::NearMap;

namespace {

constexpr char kUnknown[] = "another robot";
// Shares of the diagonal of the box around all keyframes.
constexpr double kShownShare = 1.0 / 7;
constexpr double kNearShare = 1.0 / 30;
// Of all points.
constexpr double kLeastPointsShare = 0.01;

// Says whose keyframes are, and finds each in its robot's list.
class Places {
 public:
  Places(const std::string& robot, const ServedMap& map) : robot_(robot) {
    for (const ServedMap::Keyframe& keyframe : map.keyframes) {
      agent_of_[keyframe.id.local_map] = keyframe.agent;
    }
  }
  const std::string& OwnerOf(const NearMap::NearKeyframe& keyframe) const {
    static const auto& unknown = *new std::string(kUnknown);
    if (!keyframe.shared) return robot_;
    const auto found = agent_of_.find(keyframe.id.local_map);
    return found == agent_of_.end() ? unknown : found->second;
  }

 private:
  const std::string& robot_;
  std::map<LocalMapId, std::string> agent_of_;
};

struct Place {
  MapPicture::Robot* robot = nullptr;
  size_t index = 0;
};

// Returns how far each robot usually goes from one keyframe to the next, in the picture's frame.
std::map<const MapPicture::Robot*, double> UsualSteps(const std::map<KeyframeId, Place>& places) {
  std::map<const MapPicture::Robot*, std::map<KeyframeId, Rigid3d>> poses;
  for (const auto& [id, place] : places) {
    poses[place.robot][id] = place.robot->keyframes[place.index];
  }
  std::map<const MapPicture::Robot*, double> steps;
  for (const auto& [robot, own] : poses) steps[robot] = UsualStep(own);
  return steps;
}

void AddEdges(const ServedMap& map, const std::map<KeyframeId, Place>& places) {
  const auto usual_steps = UsualSteps(places);
  for (const ServedMap::Keyframe& keyframe : map.keyframes) {
    const auto child = places.find(keyframe.id);
    const auto parent = places.find(keyframe.parent);
    if (child == places.end() || parent == places.end()) continue;
    MapPicture::Robot* const robot = child->second.robot;
    if (robot != parent->second.robot) continue;
    if (IsGap(robot->keyframes[parent->second.index], robot->keyframes[child->second.index],
              usual_steps.at(robot))) {
      continue;
    }
    robot->edges.push_back({parent->second.index, child->second.index});
  }
}

void AddPoints(const std::vector<Eigen::Vector3f>& points, MapPicture& picture) {
  for (const Eigen::Vector3f& point : points) picture.points.push_back(point.cast<double>());
}

double Diagonal(const MapPicture& picture) {
  Eigen::AlignedBox3d box;
  for (const MapPicture::Robot& robot : picture.robots) {
    for (const Rigid3d& pose : robot.keyframes) box.extend(pose.translation);
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

// Returns how much of others' keyframes lies around a place: each counts 1 at the place itself, and
// half at the distance `near`.
double WeighOthers(const MapPicture& picture, const Eigen::Vector3d& centre, double near) {
  double weight = 0;
  for (const MapPicture::Robot& robot : picture.robots) {
    if (robot.is_own) continue;
    for (const Rigid3d& pose : robot.keyframes) {
      const double ratio = (pose.translation - centre).norm() / near;
      weight += 1 / (1 + ratio * ratio);
    }
  }
  return weight;
}

// Returns nullopt where there are no own keyframes or none of others'.
std::optional<Eigen::Vector3d> FindMeeting(const MapPicture& picture, double near) {
  std::optional<Eigen::Vector3d> meeting;
  double most = 0;
  for (const MapPicture::Robot& robot : picture.robots) {
    if (!robot.is_own) continue;
    for (const Rigid3d& pose : robot.keyframes) {
      const double others = WeighOthers(picture, pose.translation, near);
      if (others <= most) continue;
      most = others;
      meeting = pose.translation;
    }
  }
  return meeting;
}

template <typename IsShown>
MapPicture::Robot CutRobot(const MapPicture::Robot& robot, const IsShown& is_shown) {
  MapPicture::Robot cut;
  cut.name = robot.name;
  cut.is_own = robot.is_own;
  std::map<size_t, size_t> index_of;  // By the index in the whole.
  for (size_t i = 0; i < robot.keyframes.size(); ++i) {
    if (!is_shown(robot.keyframes[i].translation)) continue;
    index_of[i] = cut.keyframes.size();
    cut.keyframes.push_back(robot.keyframes[i]);
  }
  for (const auto& [from, to] : robot.edges) {
    if (!index_of.contains(from) || !index_of.contains(to)) continue;
    cut.edges.push_back({index_of[from], index_of[to]});
  }
  return cut;
}

}  // namespace

MapPicture ComposeHeldPicture(const std::string& robot, const NearMap& held, const ServedMap& map) {
  const Places owners(robot, map);
  std::map<std::string, MapPicture::Robot> robots;
  std::map<KeyframeId, Place> places;
  for (const NearMap::NearKeyframe& keyframe : held.keyframes) {
    const std::string& owner = owners.OwnerOf(keyframe);
    MapPicture::Robot& drawn = robots[owner];
    drawn.name = owner;
    drawn.is_own = owner == robot;
    places[keyframe.id] = {&drawn, drawn.keyframes.size()};
    drawn.keyframes.push_back(keyframe.local_from_camera);
  }
  AddEdges(map, places);
  MapPicture picture;
  picture.title = absl::StrCat("The map that ", robot, " holds");
  for (auto& [name, drawn] : robots) picture.robots.push_back(std::move(drawn));
  AddPoints(held.own_points, picture);
  AddPoints(held.shared_points, picture);
  return picture;
}

std::optional<MapPicture> CutMeeting(const MapPicture& held) {
  const double diagonal = Diagonal(held);
  const std::optional<Eigen::Vector3d> meeting =
      FindMeeting(held, std::max(kNearShare * diagonal, 1e-9));
  if (!meeting.has_value()) return std::nullopt;
  const auto is_shown = [&](const Eigen::Vector3d& x) {
    return (x - *meeting).norm() <= kShownShare * diagonal;
  };
  MapPicture cut;
  cut.title = absl::StrCat(held.title, ", nearer");
  cut.unit = held.unit;
  for (const MapPicture::Robot& robot : held.robots) {
    cut.robots.push_back(CutRobot(robot, is_shown));
  }
  std::ranges::copy_if(held.points, std::back_inserter(cut.points), is_shown);
  if (static_cast<double>(cut.points.size()) <
      kLeastPointsShare * static_cast<double>(held.points.size()))
    return std::nullopt;
  return cut;
}

}  // namespace corbslam::services
