#include "slam/verification/testing/synthetic_world.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

namespace corbslam::testing {
namespace {

constexpr double kNearest_m = 1.5;
constexpr double kFarthest_m = 14;
constexpr uint32_t kNodes = 60;

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

std::shared_ptr<const Camera> MakeCamera(bool is_metric) {
  return std::make_shared<Camera>(Camera{.fx_px = 300,
                                         .fy_px = 300,
                                         .cx_px = 320,
                                         .cy_px = 240,
                                         .width_px = 640,
                                         .height_px = 480,
                                         .baseline_m = is_metric ? 0.3 : 0,
                                         .close_depth_m = is_metric ? 12.0 : 0});
}

// Returns the descriptor that each of the world's points has for one map.
std::vector<size_t> Appearances(const SyntheticWorld& world, double share_of_mistaken,
                                std::mt19937_64& random) {
  std::vector<size_t> appearances(world.positions_m.size());
  for (size_t i = 0; i < appearances.size(); ++i) appearances[i] = i;
  std::vector<size_t> mistaken;
  std::uniform_real_distribution<double> unit(0, 1);
  for (size_t i = 0; i < appearances.size(); ++i) {
    if (unit(random) < share_of_mistaken) mistaken.push_back(i);
  }
  // Neighbours in the list, which are far apart in the world, swap appearances.
  for (size_t k = 0; k < mistaken.size(); ++k) {
    appearances[mistaken[k]] = mistaken[(k + 1) % mistaken.size()];
  }
  return appearances;
}

struct Seen {
  size_t point = 0;
  Keypoint keypoint;
  Descriptor descriptor;
};

std::vector<Seen> See(const SyntheticWorld& world, const Rigid3d& camera_from_world,
                      const Camera& camera, const std::vector<size_t>& appearances,
                      const SyntheticMapOptions& options, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0, 1);
  std::vector<Seen> seen;
  for (size_t i = 0; i < world.positions_m.size(); ++i) {
    const Eigen::Vector3d x = camera_from_world * world.positions_m[i];
    if (x.z() < kNearest_m || x.z() > kFarthest_m) continue;
    Eigen::Vector2d pixel = Project(camera, x);
    if (!IsInImage(camera, pixel)) continue;
    pixel += options.pixel_noise_px * Eigen::Vector2d(noise(random), noise(random));
    Keypoint keypoint;
    keypoint.x_px = static_cast<float>(pixel.x());
    keypoint.y_px = static_cast<float>(pixel.y());
    if (camera.IsMetric()) {
      keypoint.disparity_px = static_cast<float>(DisparityFromDepth(camera, x.z()) +
                                                 options.pixel_noise_px * noise(random));
    }
    Descriptor descriptor = world.descriptors[appearances[i]];
    for (int flip = 0; flip < options.flipped_bits; ++flip) {
      const uint64_t bit = random() % 256;
      descriptor.words[bit / 64] ^= uint64_t{1} << (bit % 64);
    }
    seen.push_back({i, keypoint, descriptor});
  }
  return seen;
}

std::shared_ptr<const Words> MakeWords(const std::vector<Seen>& seen,
                                       const std::vector<size_t>& appearances) {
  auto words = std::make_shared<Words>();
  std::map<uint32_t, std::vector<uint32_t>> nodes;
  for (uint32_t i = 0; i < seen.size(); ++i) {
    nodes[static_cast<uint32_t>(appearances[seen[i].point]) % kNodes].push_back(i);
  }
  for (auto& [node, features] : nodes) words->direct_index.push_back({node, std::move(features)});
  return words;
}

Rigid3d Drifted(Rigid3d next_from_previous, const SyntheticMapOptions& options) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(options.drift_yaw_rad, Eigen::Vector3d::UnitY()));
  next_from_previous.rotation = (turn * next_from_previous.rotation).normalized();
  next_from_previous.translation = turn * next_from_previous.translation;
  next_from_previous.translation *= 1 + options.drift_scale;
  return next_from_previous;
}

// A track's entries are a keyframe and a keypoint.
using Track = std::vector<std::pair<uint32_t, uint32_t>>;

void AddPoint(const SyntheticWorld& world, size_t world_point, const Track& track,
              const SyntheticMapOptions& options, SyntheticMap& result) {
  const KeyframeId reference{options.local_map, track.front().first};
  MapPoint point;
  point.id = {options.local_map, static_cast<uint32_t>(result.map.points().size())};
  point.reference = reference;
  // The position is where the drifting map puts the point.
  const Eigen::Vector3d x_in_camera =
      result.true_camera_from_world.at(reference) * world.positions_m[world_point];
  point.position_in_map =
      result.map.FindKeyframe(reference)->camera_from_map.Inverse() * (options.scale * x_in_camera);
  result.map.AddPoint(point);
  for (const auto& [k, i] : track) {
    result.map.AddObservation(point.id, {options.local_map, k}, i);
  }
  result.map.UpdatePointAppearance(point.id);
  result.world_point[point.id] = world_point;
}

void AddPoints(const SyntheticWorld& world, const std::vector<std::vector<Seen>>& seen,
               const SyntheticMapOptions& options, SyntheticMap& result) {
  std::map<size_t, Track> observations;
  for (uint32_t k = 0; k < seen.size(); ++k) {
    for (uint32_t i = 0; i < seen[k].size(); ++i) observations[seen[k][i].point].push_back({k, i});
  }
  for (const auto& [world_point, list] : observations) {
    const size_t piece = options.max_observations == 0 ? list.size() : options.max_observations;
    for (size_t begin = 0; begin < list.size(); begin += piece) {
      const auto first = list.begin() + static_cast<ptrdiff_t>(begin);
      const Track track(first,
                        first + static_cast<ptrdiff_t>(std::min(piece, list.size() - begin)));
      if (track.size() < options.min_observations) continue;
      AddPoint(world, world_point, track, options, result);
    }
  }
}

}  // namespace

SyntheticWorld MakeRingWorld(uint64_t seed, int points, double radius_m) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  SyntheticWorld world;
  for (int i = 0; i < points; ++i) {
    const double angle = Radians(360 * unit(random));
    const double radius = radius_m - 4 + 8 * unit(random);
    world.positions_m.emplace_back(radius * std::cos(angle), -3 + 6 * unit(random),
                                   radius * std::sin(angle));
    Descriptor descriptor;
    for (uint64_t& word : descriptor.words) word = random();
    world.descriptors.push_back(descriptor);
  }
  return world;
}

Rigid3d PoseOnRing(double degrees, double radius_m) {
  const double angle = Radians(degrees);
  const Eigen::Vector3d forward(-std::sin(angle), 0, std::cos(angle));
  const Eigen::Vector3d down = Eigen::Vector3d::UnitY();
  Eigen::Matrix3d world_from_camera;
  world_from_camera.col(0) = down.cross(forward);
  world_from_camera.col(1) = down;
  world_from_camera.col(2) = forward;
  const Rigid3d pose{Eigen::Quaterniond(world_from_camera),
                     {radius_m * std::cos(angle), 0, radius_m * std::sin(angle)}};
  return pose.Inverse();
}

std::vector<Rigid3d> PosesOnRing(double begin_degrees, double step_degrees, int count,
                                 double radius_m) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back(PoseOnRing(begin_degrees + i * step_degrees, radius_m));
  }
  return poses;
}

SyntheticMap MakeSyntheticMap(const SyntheticWorld& world, const std::vector<Rigid3d>& poses,
                              const SyntheticMapOptions& options) {
  std::mt19937_64 random(options.seed);
  const std::vector<size_t> appearances = Appearances(world, options.share_of_mistaken, random);
  const auto camera = MakeCamera(options.scale == 1);
  SyntheticMap result;
  std::vector<std::vector<Seen>> seen;
  Rigid3d camera_from_map;
  for (uint32_t k = 0; k < poses.size(); ++k) {
    if (k > 0) {
      Rigid3d step = Drifted(poses[k] * poses[k - 1].Inverse(), options);
      step.translation *= options.scale;
      camera_from_map = step * camera_from_map;
    }
    const KeyframeId id{options.local_map, k};
    result.true_camera_from_world[id] = poses[k];
    seen.push_back(See(world, poses[k], *camera, appearances, options, random));
    Features features;
    for (const Seen& one : seen.back()) {
      features.keypoints.push_back(one.keypoint);
      features.descriptors.push_back(one.descriptor);
    }
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(id, k, 0, camera, std::move(features));
    keyframe.words = MakeWords(seen.back(), appearances);
    keyframe.camera_from_map = camera_from_map;
    if (k > 0) keyframe.parent = {options.local_map, k - 1};
    result.map.AddKeyframe(std::move(keyframe));
  }
  AddPoints(world, seen, options, result);
  return result;
}

double AteRmse_m(const std::map<KeyframeId, Rigid3d>& estimate,
                 const std::map<KeyframeId, Rigid3d>& truth) {
  Eigen::Matrix3Xd from(3, estimate.size());
  Eigen::Matrix3Xd to(3, estimate.size());
  Eigen::Index count = 0;
  for (const auto& [id, pose] : estimate) {
    const auto it = truth.find(id);
    if (it == truth.end()) continue;
    from.col(count) = CameraCentre(pose);
    to.col(count++) = CameraCentre(it->second);
  }
  from.conservativeResize(3, count);
  to.conservativeResize(3, count);
  const Eigen::Matrix4d align = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3Xd error =
      ((align.topLeftCorner<3, 3>() * from).colwise() + align.topRightCorner<3, 1>().col(0)) - to;
  return std::sqrt(error.squaredNorm() / static_cast<double>(count));
}

std::map<KeyframeId, Rigid3d> PosesOf(const Map& map) {
  std::map<KeyframeId, Rigid3d> poses;
  for (const auto& [id, keyframe] : map.keyframes()) poses[id] = keyframe.camera_from_map;
  return poses;
}

double MeanReprojectionError_px2(const Map& map) {
  double sum = 0;
  int count = 0;
  for (const auto& [id, point] : map.points()) {
    for (const auto& [keyframe_id, keypoint] : point.observations) {
      const Keyframe& keyframe = *map.FindKeyframe(keyframe_id);
      const Eigen::Vector3d x = keyframe.camera_from_map * point.position_in_map;
      const double error =
          x.z() <= 0 ? 100
                     : (Project(keyframe.camera(), x) - keyframe.keypoints()[keypoint].Pixel())
                           .squaredNorm();
      sum += std::min(error, 100.0);
      ++count;
    }
  }
  return count == 0 ? 0 : sum / count;
}

}  // namespace corbslam::testing
