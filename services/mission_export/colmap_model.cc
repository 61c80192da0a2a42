#include "services/mission_export/colmap_model.h"

#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "map_store/island_view.h"
#include "services/mission_export/robot_colours.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

// From our pixels to COLMAP's.
constexpr double kHalfPixel = 0.5;

// COLMAP numbers from 1.
struct Numbers {
  std::map<std::pair<LocalMapId, uint32_t>, size_t> cameras;
  std::map<KeyframeId, size_t> images;
  std::map<MapPointId, size_t> points;
};

std::pair<LocalMapId, uint32_t> CameraKey(const Keyframe& keyframe) {
  return {keyframe.id().local_map, keyframe.payload->camera_index};
}

Numbers NumberAll(const Map& map) {
  Numbers numbers;
  for (const auto& [id, keyframe] : map.keyframes()) {
    numbers.images.emplace(id, numbers.images.size() + 1);
    numbers.cameras.emplace(CameraKey(keyframe), numbers.cameras.size() + 1);
  }
  for (const auto& [id, point] : map.points()) {
    if (!point.observations.empty()) numbers.points.emplace(id, numbers.points.size() + 1);
  }
  return numbers;
}

std::string Name(const std::map<LocalMapId, std::string>& robots, LocalMapId local_map) {
  const auto it = robots.find(local_map);
  return it == robots.end() ? ToString(local_map) : it->second;
}

absl::Status WriteCameras(const Map& map, const Numbers& numbers, const std::string& path) {
  std::vector<std::string> lines = {"# CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY"};
  std::set<size_t> written;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const size_t number = numbers.cameras.at(CameraKey(keyframe));
    if (!written.insert(number).second) continue;
    const Camera& camera = keyframe.camera();
    lines.push_back(absl::StrFormat("%d PINHOLE %d %d %.9g %.9g %.9g %.9g", number, camera.width_px,
                                    camera.height_px, camera.fx_px, camera.fy_px,
                                    camera.cx_px + kHalfPixel, camera.cy_px + kHalfPixel));
  }
  return WriteLines(lines, path);
}

// The line of its pose, then that of its keypoints.
void AddImage(const Keyframe& keyframe, const Numbers& numbers, const std::string& robot,
              std::vector<std::string>& lines) {
  const Eigen::Quaterniond& q = keyframe.camera_from_map.rotation;
  const Eigen::Vector3d& t = keyframe.camera_from_map.translation;
  lines.push_back(absl::StrFormat("%d %.12g %.12g %.12g %.12g %.9g %.9g %.9g %d %s/%d.png",
                                  numbers.images.at(keyframe.id()), q.w(), q.x(), q.y(), q.z(),
                                  t.x(), t.y(), t.z(), numbers.cameras.at(CameraKey(keyframe)),
                                  robot, keyframe.payload->timestamp_ns));
  std::string& keypoints = lines.emplace_back();
  for (size_t i = 0; i < keyframe.keypoints().size(); ++i) {
    const Eigen::Vector2d pixel = keyframe.keypoints()[i].Pixel();
    const auto point = numbers.points.find(keyframe.points[i]);
    absl::StrAppendFormat(&keypoints, "%s%.3f %.3f ", keypoints.empty() ? "" : " ",
                          pixel.x() + kHalfPixel, pixel.y() + kHalfPixel);
    absl::StrAppend(&keypoints, point == numbers.points.end() ? "-1" : absl::StrCat(point->second));
  }
}

absl::Status WriteImages(const Map& map, const Numbers& numbers,
                         const std::map<LocalMapId, std::string>& robots, const std::string& path) {
  std::vector<std::string> lines = {"# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME",
                                    "# X Y POINT3D_ID of each keypoint, -1: none"};
  for (const auto& [id, keyframe] : map.keyframes()) {
    AddImage(keyframe, numbers, Name(robots, id.local_map), lines);
  }
  return WriteLines(lines, path);
}

// Pixels; the mean over all who see it with the point before them.
double MeanReprojectionError(const Map& map, const MapPoint& point) {
  double sum_px = 0;
  size_t count = 0;
  for (const auto& [id, keypoint] : point.observations) {
    const Keyframe& keyframe = *map.FindKeyframe(id);
    const Eigen::Vector3d x_in_camera = keyframe.camera_from_map * point.position_in_map;
    if (x_in_camera.z() <= 0) continue;
    sum_px +=
        (Project(keyframe.camera(), x_in_camera) - keyframe.keypoints()[keypoint].Pixel()).norm();
    ++count;
  }
  return count == 0 ? 0 : sum_px / static_cast<double>(count);
}

absl::Status WritePoints(const Map& map, const Numbers& numbers,
                         const std::map<LocalMapId, std::string>& robots, const std::string& path) {
  std::set<std::string> names;
  for (const auto& [local_map, name] : robots) names.insert(name);
  const std::map<std::string, Colour> colours = ChooseColours(names);
  std::vector<std::string> lines = {
      "# POINT3D_ID X Y Z R G B ERROR, then IMAGE_ID POINT2D_IDX of each that sees it"};
  for (const auto& [id, number] : numbers.points) {
    const MapPoint& point = *map.FindPoint(id);
    const auto colour = colours.find(Name(robots, id.local_map));
    const Colour rgb = colour == colours.end() ? Colour() : colour->second;
    const Eigen::Vector3d& x = point.position_in_map;
    std::string& line = lines.emplace_back(
        absl::StrFormat("%d %.9g %.9g %.9g %d %d %d %.4f", number, x.x(), x.y(), x.z(), rgb.red,
                        rgb.green, rgb.blue, MeanReprojectionError(map, point)));
    for (const auto& [keyframe, keypoint] : point.observations) {
      absl::StrAppend(&line, " ", numbers.images.at(keyframe), " ", keypoint);
    }
  }
  return WriteLines(lines, path);
}

}  // namespace

absl::StatusOr<Map> GlobalMapOf(const map_store::MissionState& state) {
  const auto island = state.global.islands.find(state.ReferenceIsland());
  if (island == state.global.islands.end()) {
    return absl::NotFoundError(absl::StrCat("mission ", state.name, " has no keyframes yet"));
  }
  map_store::UnbrokenRead read;
  ASSIGN_OR_RETURN(map_store::IslandSnapshot snapshot,
                   map_store::TakeWholeSnapshot(state, island->second, {},
                                                map_store::Rejected::kLeaveOut, read));
  return std::move(snapshot.view);
}

absl::StatusOr<ColmapCounts> WriteColmapModel(const Map& map,
                                              const std::map<LocalMapId, std::string>& robots,
                                              const std::string& folder) {
  RETURN_IF_ERROR(MakeFolder(folder));
  const Numbers numbers = NumberAll(map);
  RETURN_IF_ERROR(WriteCameras(map, numbers, folder + "/cameras.txt"));
  RETURN_IF_ERROR(WriteImages(map, numbers, robots, folder + "/images.txt"));
  RETURN_IF_ERROR(WritePoints(map, numbers, robots, folder + "/points3D.txt"));
  ColmapCounts counts = {numbers.cameras.size(), numbers.images.size(), numbers.points.size()};
  for (const auto& [id, point] : map.points()) counts.observations += point.observations.size();
  return counts;
}

}  // namespace corbslam
