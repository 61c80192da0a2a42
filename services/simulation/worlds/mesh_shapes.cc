#include "services/simulation/worlds/mesh_shapes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace corbslam {
namespace {

using Eigen::Vector3f;

// Faces of one shape are of one stuff and colour, but no two have the same pattern.
constexpr float kBetweenFacesM = 37;

// Returns whether the first three corners say which plane it is.
bool SpansPlane(const std::vector<Vector3f>& corners) {
  return (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() > 1e-7F;
}

}  // namespace

void AddQuad(const Vector3f& a, const Vector3f& b, const Vector3f& c, const Vector3f& d,
             const Finish& finish, Mesh* mesh) {
  Patch patch;
  patch.corners = {a, b, c, d};
  patch.u_axis = (b - a).normalized();
  const Vector3f normal = (b - a).cross(c - a).normalized();
  patch.v_axis = normal.cross(patch.u_axis);
  patch.u_offset_m = -patch.u_axis.dot(a);
  patch.v_offset_m = -patch.v_axis.dot(a);
  patch.material = finish.material;
  patch.seed = finish.seed;
  patch.tone = finish.tone;
  mesh->patches.push_back(patch);
}

void AddPolygon(const std::vector<Vector3f>& corners, const Finish& finish, Mesh* mesh) {
  if (corners.size() < 3 || !SpansPlane(corners)) return;
  const size_t first = mesh->patches.size();
  for (size_t i = 1; i + 1 < corners.size(); i += 2) {
    const size_t last = std::min(i + 2, corners.size() - 1);
    AddQuad(corners[0], corners[i], corners[i + 1], corners[last], finish, mesh);
    Patch& patch = mesh->patches.back();
    const Patch& model = mesh->patches[first];
    patch.u_axis = model.u_axis;
    patch.v_axis = model.v_axis;
    patch.u_offset_m = model.u_offset_m;
    patch.v_offset_m = model.v_offset_m;
  }
}

void AddBox(const Vector3f& low, const Vector3f& high, const Finish& finish, Mesh* mesh,
            bool bottom) {
  const Vector3f size = high - low;
  const Vector3f x(size.x(), 0, 0);
  const Vector3f y(0, size.y(), 0);
  const Vector3f z(0, 0, size.z());
  const auto add = [&](const Vector3f& origin, const Vector3f& u, const Vector3f& v, int face) {
    mesh->patches.push_back(Rectangle(origin, u, v, finish.material, finish.seed, finish.tone));
    mesh->patches.back().u_offset_m += kBetweenFacesM * static_cast<float>(face);
  };
  add(low, x, y, 0);
  add(low + x + z, -x, y, 1);
  add(low + z, -z, y, 2);
  add(low + x, z, y, 3);
  add(low + z, x, -z, 4);
  if (bottom) add(low + y, x, z, 5);
}

void AddTube(const Vector3f& from, const Vector3f& to, float from_radius, float to_radius,
             int sides, const Finish& finish, Mesh* mesh) {
  const Vector3f along = (to - from).normalized();
  const Vector3f across = along.unitOrthogonal();
  const Vector3f third = along.cross(across);
  const auto rim = [&](int i) -> Vector3f {
    const float angle = static_cast<float>(2 * std::numbers::pi) * static_cast<float>(i) /
                        static_cast<float>(sides);
    return std::cos(angle) * across + std::sin(angle) * third;
  };
  for (int i = 0; i < sides; ++i) {
    // A trapezium of equal sides is flat.
    AddQuad(to + to_radius * rim(i), to + to_radius * rim(i + 1), from + from_radius * rim(i + 1),
            from + from_radius * rim(i), finish, mesh);
    mesh->patches.back().u_offset_m += kBetweenFacesM * static_cast<float>(i);
  }
}

void AddDisc(const Vector3f& centre, const Vector3f& normal, float radius, const Finish& finish,
             Mesh* mesh) {
  const Vector3f across = normal.unitOrthogonal();
  const Vector3f third = normal.normalized().cross(across);
  std::vector<Vector3f> corners;
  for (int i = 0; i < 8; ++i) {
    const float angle = static_cast<float>(std::numbers::pi / 4) * (static_cast<float>(i) + 0.5F);
    corners.push_back(centre + radius * (std::cos(angle) * across + std::sin(angle) * third));
  }
  AddPolygon(corners, finish, mesh);
}

void AppendMoved(const Mesh& mesh, const Rigid3d& to_from_mesh, Mesh* to) {
  const Eigen::Matrix3f rotation = to_from_mesh.rotation.toRotationMatrix().cast<float>();
  const Vector3f translation = to_from_mesh.translation.cast<float>();
  to->patches.reserve(to->patches.size() + mesh.patches.size());
  for (Patch patch : mesh.patches) {
    for (Vector3f& corner : patch.corners) corner = rotation * corner + translation;
    patch.u_axis = rotation * patch.u_axis;
    patch.v_axis = rotation * patch.v_axis;
    patch.u_offset_m -= patch.u_axis.dot(translation);
    patch.v_offset_m -= patch.v_axis.dot(translation);
    to->patches.push_back(patch);
  }
}

Rigid3d Upright(const Eigen::Vector3d& origin, const Eigen::Vector2d& ahead) {
  const double angle = std::atan2(ahead.x(), ahead.y());
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())), origin};
}

}  // namespace corbslam
