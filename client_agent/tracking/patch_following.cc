#include "client_agent/tracking/patch_following.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "slam/sensor/patch_search.h"

namespace corbslam::client_agent {
namespace {

// Steps by which it is found out how a surface is turned and scaled.
constexpr double kStep_px = 4;
// A patch is found to a part of a pixel, whatever octave its corner was found on; how well its
// point is known still grows with that.
constexpr int kCoarsest = 3;
// Beyond, a patch looks too different.
constexpr double kMostScale = 3;

// A surface is taken to face the camera that saw it.
std::optional<Eigen::Matrix2d> SourceFromNow(const FreshPicture& fresh, const Camera& camera,
                                             const Rigid3d& now_from_source,
                                             const Eigen::Vector2d& source_px, double depth_m) {
  const auto corner = [&](double x, double y) -> Eigen::Vector2d {
    return source_px + Eigen::Vector2d(x, y);
  };
  const std::array<Eigen::Vector2d, 3> ideal = {corner(0, 0), corner(kStep_px, 0),
                                                corner(0, kStep_px)};
  std::array<Eigen::Vector2d, 3> in_source;
  std::array<Eigen::Vector2d, 3> in_now;
  for (size_t i = 0; i < ideal.size(); ++i) {
    const auto source = fresh.sensor->InPicture(ideal[i]);
    const Eigen::Vector3d x_in_now =
        now_from_source * Unproject(camera, ideal[i].x(), ideal[i].y(), depth_m);
    if (!source.has_value() || !(x_in_now.z() > 0)) return std::nullopt;
    const auto now = fresh.sensor->InPicture(Project(camera, x_in_now));
    if (!now.has_value()) return std::nullopt;
    in_source[i] = *source;
    in_now[i] = *now;
  }
  Eigen::Matrix2d source_steps, now_steps;
  source_steps << in_source[1] - in_source[0], in_source[2] - in_source[0];
  now_steps << in_now[1] - in_now[0], in_now[2] - in_now[0];
  const double scale2 = now_steps.determinant() / source_steps.determinant();
  if (!(scale2 > 1 / (kMostScale * kMostScale) && scale2 < kMostScale * kMostScale)) {
    return std::nullopt;
  }
  return source_steps * now_steps.inverse();
}

// A corner of a small picture may be none in the large one.
int FirstLevelOf(const PatchSource& source) { return source.octave < kCoarsest ? 0 : 1; }

// Returns where the source is seen, as a keypoint of the camera.
std::optional<Keypoint> Find(const FreshPicture& fresh, const Camera& camera,
                             const Rigid3d& camera_from_map, const PatchSource& source,
                             int first_level) {
  const Eigen::Vector3d x_in_now = camera_from_map * source.position_in_map;
  const double depth_m = (source.source_from_map * source.position_in_map).z();
  if (!(x_in_now.z() > 0 && depth_m > 0)) return std::nullopt;
  const auto predicted = fresh.sensor->InPicture(Project(camera, x_in_now));
  const auto source_px = fresh.sensor->InPicture(source.keypoint.Pixel());
  if (!predicted.has_value() || !source_px.has_value()) return std::nullopt;
  const auto warp = SourceFromNow(fresh, camera, camera_from_map * source.source_from_map.Inverse(),
                                  source.keypoint.Pixel(), depth_m);
  if (!warp.has_value()) return std::nullopt;
  const auto found = FindPatch(*source.picture, fresh.picture,
                               {.source_px = *source_px,
                                .source_from_now = *warp,
                                .predicted_px = *predicted,
                                .first_level = std::max(first_level, FirstLevelOf(source))});
  if (!found.has_value()) return std::nullopt;
  Keypoint keypoint;
  keypoint.x_px = static_cast<float>(found->x());
  keypoint.y_px = static_cast<float>(found->y());
  keypoint.angle_rad = source.keypoint.angle_rad;
  keypoint.octave = static_cast<uint8_t>(std::min(source.octave, kCoarsest));
  return fresh.sensor->FromPicture(*fresh.images, keypoint);
}

}  // namespace

Frame FollowPatches(const FreshPicture& fresh, std::shared_ptr<const Camera> camera,
                    const Rigid3d& camera_from_map, absl::Span<const PatchSource> sources,
                    int first_level) {
  KeyframePayload payload;
  payload.timestamp_ns = fresh.images->timestamp_ns;
  std::vector<Association> associations;
  for (const PatchSource& source : sources) {
    const auto keypoint = Find(fresh, *camera, camera_from_map, source, first_level);
    if (!keypoint.has_value()) continue;
    payload.features.keypoints.push_back(*keypoint);
    payload.features.descriptors.push_back(source.descriptor);
    associations.push_back({Association::Kind::kMapPoint, source.point, source.position_in_map});
  }
  payload.camera = std::move(camera);
  Frame frame = MakeFrame(std::move(payload));
  frame.associations = std::move(associations);
  frame.camera_from_map = camera_from_map;
  return frame;
}

}  // namespace corbslam::client_agent
