#include "services/tool/export/colmap_model.h"

#include <algorithm>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "map_store/view/island_view.h"
#include "services/tool/export/robot_colours.h"
#include "slam/evaluation/pose_header.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {
namespace {

// Added to our pixel coordinates, it gives COLMAP's.
constexpr double kHalfPixel = 0.5;

// Maps our ids to COLMAP's numbers, which begin with 1.
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

std::string RobotOf(const ColmapSource& source, LocalMapId local_map) {
  const auto it = source.robots.find(local_map);
  return it == source.robots.end() ? ToString(local_map) : it->second;
}

// Returns the camera that recorded the keyframe's picture, or the keyframe's own camera if the
// recorded one isn't known or wanted.
RecordedCamera RecordedOf(const ColmapSource& source, const Keyframe& keyframe) {
  const auto it = source.recorded.find(CameraKey(keyframe));
  const bool is_wanted = source.poses_of == PosesOf::kRecordedCamera;
  return it != source.recorded.end() && is_wanted ? it->second : AsRecorded(keyframe.camera());
}

struct ColmapLens {
  absl::string_view model;
  std::vector<double> coefficients;
};

ColmapLens PinholeOf(const RadialTangential& d) {
  if (d.IsZero()) return {"PINHOLE", {}};
  if (d.k3 == 0 && !d.IsRational()) return {"OPENCV", {d.k1, d.k2, d.p1, d.p2}};
  return {"FULL_OPENCV", {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6}};
}

// Returns INVALID_ARGUMENT for a lens for which COLMAP has no model.
absl::StatusOr<ColmapLens> ColmapLensOf(const LensModel& lens) {
  if (const auto* const pinhole = std::get_if<RadialTangential>(&lens)) return PinholeOf(*pinhole);
  if (const auto* const fisheye = std::get_if<Equidistant>(&lens)) {
    return ColmapLens{"OPENCV_FISHEYE", {fisheye->k1, fisheye->k2, fisheye->k3, fisheye->k4}};
  }
  return absl::InvalidArgumentError(
      absl::StrCat("COLMAP has no model of a lens that is ", NameOf(lens),
                   ": export with --poses-of rectified, for the undistorted pictures"));
}

absl::StatusOr<std::string> CameraLine(size_t number, const Camera& camera, const RawCamera& raw) {
  ASSIGN_OR_RETURN(const ColmapLens lens, ColmapLensOf(raw.lens));
  std::string line = absl::StrFormat("%d %s %d %d %.9g %.9g %.9g %.9g", number, lens.model,
                                     camera.width_px, camera.height_px, raw.fx_px, raw.fy_px,
                                     raw.cx_px + kHalfPixel, raw.cy_px + kHalfPixel);
  for (const double k : lens.coefficients) absl::StrAppendFormat(&line, " %.9g", k);
  return line;
}

absl::Status WriteCameras(const Map& map, const Numbers& numbers, const ColmapSource& source,
                          const std::string& path) {
  std::vector<std::string> lines = {"# CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY (K1 K2 P1 P2 ...)"};
  std::set<size_t> written;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const size_t number = numbers.cameras.at(CameraKey(keyframe));
    if (!written.insert(number).second) continue;
    ASSIGN_OR_RETURN(lines.emplace_back(),
                     CameraLine(number, keyframe.camera(), RecordedOf(source, keyframe).lens));
  }
  return WriteLines(lines, path);
}

// Gives each picture a name of its own, those of the robot's first local maps first.
std::map<KeyframeId, std::string> NamePictures(const Map& map, const ColmapSource& source) {
  const auto number_of = [&source](LocalMapId local_map) {
    const auto number = source.numbers.find(local_map);
    return number == source.numbers.end() ? size_t{1} : number->second;
  };
  std::vector<std::pair<size_t, KeyframeId>> in_order;
  for (const auto& [id, keyframe] : map.keyframes()) {
    in_order.emplace_back(number_of(id.local_map), id);
  }
  std::sort(in_order.begin(), in_order.end());
  std::map<KeyframeId, std::string> names;
  std::set<std::string> taken;
  for (const auto& [number, id] : in_order) {
    const std::string robot = RobotOf(source, id.local_map);
    const std::string file = absl::StrCat("/", map.FindKeyframe(id)->payload->timestamp_ns, ".png");
    std::string name = robot + file;
    if (!taken.insert(name).second) name = absl::StrCat(robot, "+", number, file);
    for (char letter = 'b'; name != robot + file && !taken.insert(name).second; ++letter) {
      name = absl::StrCat(robot, "+", number, std::string(1, letter), file);
    }
    names[id] = name;
  }
  return names;
}

// Adds the line of the image's pose, then that of its keypoints.
void AddImage(const Keyframe& keyframe, const Numbers& numbers, const RecordedCamera& recorded,
              const std::string& name, std::vector<std::string>& lines) {
  const Rigid3d pose = recorded.camera_from_recorded.Inverse() * keyframe.camera_from_map;
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  lines.push_back(absl::StrFormat(
      "%d %.12g %.12g %.12g %.12g %.9g %.9g %.9g %d %s", numbers.images.at(keyframe.id()), q.w(),
      q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), numbers.cameras.at(CameraKey(keyframe)), name));
  std::string& keypoints = lines.emplace_back();
  for (size_t i = 0; i < keyframe.keypoints().size(); ++i) {
    const Eigen::Vector2d pixel =
        RecordedPixel(keyframe.camera(), recorded, keyframe.keypoints()[i].Pixel());
    const auto point = numbers.points.find(keyframe.points[i]);
    absl::StrAppendFormat(&keypoints, "%s%.3f %.3f ", keypoints.empty() ? "" : " ",
                          pixel.x() + kHalfPixel, pixel.y() + kHalfPixel);
    absl::StrAppend(&keypoints, point == numbers.points.end() ? "-1" : absl::StrCat(point->second));
  }
}

absl::Status WriteImages(const Map& map, const Numbers& numbers, const ColmapSource& source,
                         const std::string& path) {
  std::vector<std::string> lines = {absl::StrCat("# ", PoseHeaderLine(source.poses_of)),
                                    "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME",
                                    "# X Y POINT3D_ID of each keypoint, -1: none"};
  const std::map<KeyframeId, std::string> names = NamePictures(map, source);
  for (const auto& [id, keyframe] : map.keyframes()) {
    AddImage(keyframe, numbers, RecordedOf(source, keyframe), names.at(id), lines);
  }
  return WriteLines(lines, path);
}

// Returns the mean over all keyframes that see the point with it before them, in pixels.
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

absl::Status WritePoints(const Map& map, const Numbers& numbers, const ColmapSource& source,
                         const std::string& path) {
  std::set<std::string> names;
  for (const auto& [local_map, name] : source.robots) names.insert(name);
  const std::map<std::string, Colour> colours = ChooseColours(names);
  std::vector<std::string> lines = {
      "# POINT3D_ID X Y Z R G B ERROR, then IMAGE_ID POINT2D_IDX of each that sees it"};
  for (const auto& [id, number] : numbers.points) {
    const MapPoint& point = *map.FindPoint(id);
    const auto colour = colours.find(RobotOf(source, id.local_map));
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

ColmapSource ColmapSourceOf(const map_store::MissionState& state, PosesOf poses_of) {
  ColmapSource source;
  source.poses_of = poses_of;
  for (const auto& [id, local_map] : state.local_maps) {
    for (const LocalMapId name : local_map.Names()) {
      source.robots[name] = local_map.agent;
      source.numbers[name] = state.arrivals.NumberOfAgent(name);
      for (size_t i = 0; i < local_map.cameras.size(); ++i) {
        const std::optional<RecordedCamera> recorded = local_map.Recorded(i);
        if (recorded.has_value()) source.recorded[{name, static_cast<uint32_t>(i)}] = *recorded;
      }
    }
  }
  return source;
}

absl::StatusOr<ColmapCounts> WriteColmapModel(const Map& map, const ColmapSource& source,
                                              const std::string& folder) {
  RETURN_IF_ERROR(MakeFolder(folder));
  const Numbers numbers = NumberAll(map);
  RETURN_IF_ERROR(WriteCameras(map, numbers, source, folder + "/cameras.txt"));
  RETURN_IF_ERROR(WriteImages(map, numbers, source, folder + "/images.txt"));
  RETURN_IF_ERROR(WritePoints(map, numbers, source, folder + "/points3D.txt"));
  ColmapCounts counts = {numbers.cameras.size(), numbers.images.size(), numbers.points.size()};
  for (const auto& [id, point] : map.points()) counts.observations += point.observations.size();
  return counts;
}

}  // namespace corbslam::services
