#include "services/simulation/scene_validation.h"

#include <cmath>
#include <cstddef>

#include "absl/strings/str_format.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

bool IsFinite(const Patch& patch) {
  for (const Eigen::Vector3f& corner : patch.corners) {
    if (!corner.allFinite()) return false;
  }
  return patch.u_axis.allFinite() && patch.v_axis.allFinite() && std::isfinite(patch.u_offset_m) &&
         std::isfinite(patch.v_offset_m) && std::isfinite(patch.tone);
}

absl::Status ValidateMesh(const Mesh& mesh, size_t index) {
  for (size_t i = 0; i < mesh.patches.size(); ++i) {
    if (!IsFinite(mesh.patches[i])) {
      return absl::InvalidArgumentError(
          absl::StrFormat("meshes[%d].patches[%d]: a number is not finite", index, i));
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateInstance(const Instance& instance, size_t index, size_t meshes) {
  if (instance.mesh >= meshes) {
    return absl::InvalidArgumentError(
        absl::StrFormat("instances[%d].mesh: %d, of %d meshes", index, instance.mesh, meshes));
  }
  const Similarity3d& pose = instance.world_from_mesh;
  if (!(pose.scale > 0) || !std::isfinite(pose.scale) || !pose.translation.allFinite() ||
      !pose.rotation.coeffs().allFinite()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "instances[%d].world_from_mesh: must be finite and of positive scale", index));
  }
  return absl::OkStatus();
}

absl::Status ValidateMover(const Mover& mover, size_t index, size_t meshes) {
  if (mover.mesh >= meshes) {
    return absl::InvalidArgumentError(
        absl::StrFormat("movers[%d].mesh: %d, of %d meshes", index, mover.mesh, meshes));
  }
  if (mover.path.empty()) {
    return absl::InvalidArgumentError(absl::StrFormat("movers[%d].path: is empty", index));
  }
  for (size_t i = 0; i < mover.path.size(); ++i) {
    const Mover::Waypoint& at = mover.path[i];
    if (!std::isfinite(at.time_s) || !at.world_from_mesh.translation.allFinite() ||
        !at.world_from_mesh.rotation.coeffs().allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("movers[%d].path[%d]: a number is not finite", index, i));
    }
    if (i > 0 && at.time_s <= mover.path[i - 1].time_s) {
      return absl::InvalidArgumentError(
          absl::StrFormat("movers[%d].path[%d].time_s: %f, not after %f", index, i, at.time_s,
                          mover.path[i - 1].time_s));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const Scene& scene) {
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    RETURN_IF_ERROR(ValidateMesh(scene.meshes[i], i));
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    RETURN_IF_ERROR(ValidateInstance(scene.instances[i], i, scene.meshes.size()));
  }
  for (size_t i = 0; i < scene.movers.size(); ++i) {
    RETURN_IF_ERROR(ValidateMover(scene.movers[i], i, scene.meshes.size()));
  }
  return absl::OkStatus();
}

}  // namespace corbslam
