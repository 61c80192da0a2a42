#include "slam/optimisation/testing/synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <random>

#include "slam/geometry/lie.h"

namespace corbslam::testing {
namespace {

// std's distributions differ between libraries; these are the same everywhere.
class Random {
 public:
  explicit Random(uint64_t seed) : generator_(seed) {}

  uint64_t Bits() { return generator_(); }
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(Bits() >> 11) * 0x1p-53;
  }
  double Gaussian(double sigma) {
    const double radius = std::sqrt(-2 * std::log(1 - Uniform(0, 1)));
    return sigma * radius * std::cos(Uniform(0, 2 * M_PI));
  }
  Eigen::Vector3d GaussianVector(double sigma) {
    const double x = Gaussian(sigma);
    const double y = Gaussian(sigma);
    return {x, y, Gaussian(sigma)};
  }

 private:
  std::mt19937_64 generator_;
};

struct Sighting {
  size_t point = 0;
  Keypoint keypoint;
};

Rigid3d TruePose(const SyntheticSceneOptions& options, int index) {
  const double turn_rad = 0.1 * std::sin(0.7 * index);
  const Eigen::Quaterniond map_from_camera = ExpSO3({0.3 * turn_rad, turn_rad, 0.02 * index / 10});
  const Eigen::Vector3d centre(options.step_m * index, 0.1 * std::sin(index),
                               0.1 * std::cos(index));
  return Rigid3d{map_from_camera, centre}.Inverse();
}

std::vector<Eigen::Vector3d> TruePositions(const SyntheticSceneOptions& options, Random& random) {
  std::vector<Eigen::Vector3d> positions;
  const double length_m = options.step_m * (options.keyframes - 1);
  for (int i = 0; i < options.points; ++i) {
    const double z = random.Uniform(options.nearest_m, options.farthest_m);
    const double x = random.Uniform(-0.4 * z, length_m + 0.4 * z);
    positions.emplace_back(x, random.Uniform(-0.35 * z, 0.35 * z), z);
  }
  return positions;
}

std::vector<Descriptor> PointDescriptors(size_t count, Random& random) {
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors) {
    for (uint64_t& word : descriptor.words) word = random.Bits();
  }
  return descriptors;
}

Descriptor FlipSomeBits(Descriptor descriptor, Random& random) {
  for (int i = 0; i < 8; ++i) {
    const uint64_t bit = random.Bits() % 256;
    descriptor.words[bit / 64] ^= uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

class SceneBuilder {
 public:
  explicit SceneBuilder(const SyntheticSceneOptions& options)
      : options_(options), random_(options.seed), camera_(SyntheticCamera()) {
    scene_.camera = camera_;
    positions_ = TruePositions(options, random_);
    descriptors_ = PointDescriptors(positions_.size(), random_);
    sightings_.resize(static_cast<size_t>(options.keyframes));
  }

  SyntheticScene Build() {
    SeePoints();
    AddKeyframes();
    AddPoints();
    AddObservations();
    Disturb();
    std::sort(scene_.outliers.begin(), scene_.outliers.end());
    return std::move(scene_);
  }

 private:
  KeyframeId IdOfKeyframe(size_t index) const {
    return {options_.local_map, static_cast<uint32_t>(index)};
  }
  MapPointId IdOfPoint(size_t index) const {
    return {options_.local_map, static_cast<uint32_t>(index)};
  }

  // Decides which keyframes see which point, with exact pixels.
  void SeePoints() {
    std::vector<Rigid3d> poses;
    for (int i = 0; i < options_.keyframes; ++i) poses.push_back(TruePose(options_, i));
    for (size_t p = 0; p < positions_.size(); ++p) {
      std::vector<size_t> observers;
      for (size_t k = 0; k < poses.size(); ++k) {
        const Eigen::Vector3d x = poses[k] * positions_[p];
        if (x.z() > 0.5 && IsInImage(camera_, Project(camera_, x))) observers.push_back(k);
      }
      const auto limit = static_cast<size_t>(options_.max_observations_per_point);
      if (limit > 0 && observers.size() > limit) {
        const size_t first = random_.Bits() % (observers.size() - limit + 1);
        observers.erase(observers.begin(), observers.begin() + static_cast<std::ptrdiff_t>(first));
        observers.resize(limit);
      }
      if (observers.size() < 2) continue;
      for (const size_t k : observers) sightings_[k].push_back(See(p, poses[k] * positions_[p]));
    }
    for (size_t k = 0; k < poses.size(); ++k) {
      scene_.true_camera_from_map[IdOfKeyframe(k)] = poses[k];
    }
  }

  Sighting See(size_t point, const Eigen::Vector3d& x_in_camera) {
    Keypoint keypoint;
    const double distance = x_in_camera.norm();
    keypoint.octave = static_cast<uint8_t>(
        ScalePyramid::PredictOctave(2 * options_.farthest_m, 2 * distance) / 2);
    const double noise_px = options_.pixel_noise_px * ScalePyramid::Scale(keypoint.octave);
    const Eigen::Vector2d pixel = Project(camera_, x_in_camera);
    const double x_px = pixel.x() + random_.Gaussian(noise_px);
    const double right_px =
        pixel.x() - DisparityFromDepth(camera_, x_in_camera.z()) + random_.Gaussian(noise_px);
    keypoint.x_px = static_cast<float>(x_px);
    keypoint.y_px = static_cast<float>(pixel.y() + random_.Gaussian(noise_px));
    if (random_.Uniform(0, 1) < options_.share_with_depth) {
      keypoint.disparity_px = static_cast<float>(x_px - right_px - FalseDepth_px(keypoint.octave));
    }
    return {point, keypoint};
  }

  // It draws no random number where there are none, so that other scenes stay what they were.
  double FalseDepth_px(int octave) {
    if (options_.share_of_false_depths == 0) return 0;
    if (random_.Uniform(0, 1) >= options_.share_of_false_depths) return 0;
    return random_.Uniform(1.5, 2) * ScalePyramid::Scale(octave);
  }

  void AddKeyframes() {
    const auto camera = std::make_shared<const Camera>(camera_);
    for (size_t k = 0; k < sightings_.size(); ++k) {
      Features features;
      for (Sighting& sighting : sightings_[k]) {
        MaybeDisplace(k, sighting);
        features.keypoints.push_back(sighting.keypoint);
        features.descriptors.push_back(FlipSomeBits(descriptors_[sighting.point], random_));
      }
      Keyframe keyframe;
      keyframe.payload = MakeKeyframePayload(IdOfKeyframe(k), static_cast<int64_t>(k) * 100'000'000,
                                             0, camera, std::move(features));
      keyframe.camera_from_map = scene_.true_camera_from_map[IdOfKeyframe(k)];
      if (k > 0) keyframe.parent = IdOfKeyframe(k - 1);
      scene_.map.AddKeyframe(std::move(keyframe));
    }
  }

  void MaybeDisplace(size_t keyframe, Sighting& sighting) {
    if (random_.Uniform(0, 1) >= options_.share_of_outliers) return;
    const double angle_rad = random_.Uniform(0, 2 * M_PI);
    const double distance_px = random_.Uniform(20, 60);
    sighting.keypoint.x_px += static_cast<float>(distance_px * std::cos(angle_rad));
    sighting.keypoint.y_px += static_cast<float>(distance_px * std::sin(angle_rad));
    scene_.outliers.emplace_back(IdOfPoint(sighting.point), IdOfKeyframe(keyframe));
  }

  void AddPoints() {
    std::vector<char> is_seen(positions_.size(), 0);
    for (const auto& sightings : sightings_) {
      for (const Sighting& sighting : sightings) is_seen[sighting.point] = 1;
    }
    for (size_t p = 0; p < positions_.size(); ++p) {
      if (!is_seen[p]) continue;
      MapPoint point;
      point.id = IdOfPoint(p);
      point.position_in_map = positions_[p];
      point.descriptor = descriptors_[p];
      scene_.map.AddPoint(std::move(point));
      scene_.true_position_in_map[IdOfPoint(p)] = positions_[p];
    }
  }

  void AddObservations() {
    for (size_t k = 0; k < sightings_.size(); ++k) {
      for (size_t i = 0; i < sightings_[k].size(); ++i) {
        scene_.map.AddObservation(IdOfPoint(sightings_[k][i].point), IdOfKeyframe(k),
                                  static_cast<uint32_t>(i));
      }
    }
    for (const auto& [id, position] : scene_.true_position_in_map) {
      scene_.map.UpdatePointAppearance(id);
    }
  }

  void Disturb() {
    for (const auto& [id, pose] : scene_.true_camera_from_map) {
      if (id.index == 0) continue;
      const Eigen::Vector3d translation = random_.GaussianVector(options_.pose_noise_m);
      const Eigen::Vector3d rotation = random_.GaussianVector(options_.pose_noise_rad);
      scene_.map.SetPose(id, Rigid3d{ExpSO3(rotation), translation} * pose);
    }
    for (const auto& [id, position] : scene_.true_position_in_map) {
      scene_.map.SetPosition(id, position + random_.GaussianVector(options_.point_noise_m));
    }
  }

  const SyntheticSceneOptions options_;
  Random random_;
  Camera camera_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Descriptor> descriptors_;
  std::vector<std::vector<Sighting>> sightings_;
  SyntheticScene scene_;
};

}  // namespace

Camera SyntheticCamera() {
  Camera camera;
  camera.fx_px = 458;
  camera.fy_px = 457;
  camera.cx_px = 367;
  camera.cy_px = 248;
  camera.width_px = 752;
  camera.height_px = 480;
  camera.baseline_m = 0.11;
  camera.close_depth_m = 4.4;
  return camera;
}

SyntheticScene MakeSyntheticScene(const SyntheticSceneOptions& options) {
  return SceneBuilder(options).Build();
}

size_t CountObservations(const Map& map) {
  size_t count = 0;
  for (const auto& [id, point] : map.points()) count += point.observations.size();
  return count;
}

}  // namespace corbslam::testing
