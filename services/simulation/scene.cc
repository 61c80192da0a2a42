#include "services/simulation/scene.h"

#include <algorithm>

#include "slam/geometry/interpolation.h"

namespace corbslam {

Patch Rectangle(const Eigen::Vector3f& origin, const Eigen::Vector3f& edge_u,
                const Eigen::Vector3f& edge_v, Material material, uint32_t seed, float tone) {
  Patch patch;
  patch.corners = {origin, origin + edge_u, origin + edge_u + edge_v, origin + edge_v};
  patch.u_axis = edge_u.normalized();
  patch.v_axis = edge_v.normalized();
  patch.u_offset_m = -patch.u_axis.dot(origin);
  patch.v_offset_m = -patch.v_axis.dot(origin);
  patch.material = material;
  patch.seed = seed;
  patch.tone = tone;
  return patch;
}

Rigid3d PoseAt(const Mover& mover, double time_s) {
  const auto after = std::find_if(mover.path.begin(), mover.path.end(),
                                  [&](const auto& waypoint) { return waypoint.time_s > time_s; });
  if (after == mover.path.begin()) return mover.path.front().world_from_mesh;
  if (after == mover.path.end()) return mover.path.back().world_from_mesh;
  const Mover::Waypoint& from = *(after - 1);
  const double share = (time_s - from.time_s) / (after->time_s - from.time_s);
  return Interpolate(from.world_from_mesh, after->world_from_mesh, share);
}

}  // namespace corbslam
