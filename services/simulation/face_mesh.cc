#include "services/simulation/face_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace corbslam {
namespace {

using Eigen::Vector3f;

// A cluster is found hidden as a whole.
constexpr ptrdiff_t kMostFacesInCluster = 64;

struct Face {
  std::array<Vector3f, 4> corners;
  uint32_t patch;
  Vector3f centre;
};

PatchSurface MakeSurface(const Patch& patch) {
  const Vector3f across = patch.corners[2] - patch.corners[0];
  const Vector3f other = patch.corners[3] - patch.corners[1];
  return {.u_axis = patch.u_axis,
          .v_axis = patch.v_axis,
          .normal = across.cross(other).normalized(),
          .u_offset_m = patch.u_offset_m,
          .v_offset_m = patch.v_offset_m,
          .tone = patch.tone,
          .seed = patch.seed,
          .material = patch.material};
}

bool IsFlatAndConvex(const std::array<Vector3f, 4>& corners) {
  constexpr float kFlat = 1e-3F;  // Share of the longest diagonal.
  const Vector3f across = corners[2] - corners[0];
  const Vector3f other = corners[3] - corners[1];
  const Vector3f normal = across.cross(other).normalized();
  const float size = std::max(across.norm(), other.norm());
  if (std::abs(normal.dot(corners[1] - corners[0])) > kFlat * size) return false;
  for (size_t k = 0; k < 4; ++k) {
    const Vector3f before = corners[(k + 1) % 4] - corners[k];
    const Vector3f after = corners[(k + 2) % 4] - corners[(k + 1) % 4];
    if (normal.dot(before.cross(after)) < 0) return false;
  }
  return true;
}

Face MakeFace(const std::array<Vector3f, 4>& corners, uint32_t patch) {
  return {corners, patch, 0.25F * (corners[0] + corners[1] + corners[2] + corners[3])};
}

std::vector<Face> FacesOf(const Mesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(mesh.patches.size());
  for (uint32_t i = 0; i < mesh.patches.size(); ++i) {
    const std::array<Vector3f, 4>& at = mesh.patches[i].corners;
    if (IsFlatAndConvex(at)) {
      faces.push_back(MakeFace(at, i));
    } else {
      faces.push_back(MakeFace({at[0], at[1], at[2], at[2]}, i));
      faces.push_back(MakeFace({at[0], at[2], at[3], at[3]}, i));
    }
  }
  return faces;
}

void AddGroup(const Face* first, size_t count, FaceMesh* mesh) {
  FaceGroup group;
  group.count = count;
  for (size_t lane = 0; lane < kNumbers; ++lane) {
    const Face& face = first[std::min(lane, count - 1)];
    for (size_t k = 0; k < 4; ++k) {
      group.x[k].lanes[lane] = face.corners[k].x();
      group.y[k].lanes[lane] = face.corners[k].y();
      group.z[k].lanes[lane] = face.corners[k].z();
    }
    group.patch.lanes[lane] = face.patch;
  }
  mesh->groups.push_back(group);
}

void AddCluster(const Face* first, const Face* last, FaceMesh* mesh) {
  FaceCluster cluster;
  cluster.first_group = static_cast<uint32_t>(mesh->groups.size());
  for (const Face* face = first; face != last; ++face) {
    for (const Vector3f& corner : face->corners) cluster.bounds.extend(corner);
  }
  for (; first < last; first += kNumbers) {
    AddGroup(first, static_cast<size_t>(std::min<ptrdiff_t>(kNumbers, last - first)), mesh);
  }
  cluster.group_count = static_cast<uint32_t>(mesh->groups.size()) - cluster.first_group;
  mesh->bounds.extend(cluster.bounds);
  mesh->clusters.push_back(cluster);
}

// Halves the faces along the longest side until they are few.
void Divide(Face* first, Face* last, FaceMesh* mesh) {
  if (last - first <= kMostFacesInCluster) {
    AddCluster(first, last, mesh);
    return;
  }
  Eigen::AlignedBox3f centres;
  for (const Face* face = first; face != last; ++face) centres.extend(face->centre);
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  // The first half holds whole groups of eight.
  const ptrdiff_t half = (last - first) / 2 / kNumbers * kNumbers;
  std::nth_element(first, first + half, last, [axis](const Face& a, const Face& b) {
    return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis] : a.patch < b.patch;
  });
  Divide(first, first + half, mesh);
  Divide(first + half, last, mesh);
}

}  // namespace

FaceMesh MakeFaceMesh(const Mesh& mesh) {
  FaceMesh made;
  made.surfaces.reserve(mesh.patches.size());
  for (const Patch& patch : mesh.patches) made.surfaces.push_back(MakeSurface(patch));
  std::vector<Face> faces = FacesOf(mesh);
  if (!faces.empty()) Divide(faces.data(), faces.data() + faces.size(), &made);
  return made;
}

}  // namespace corbslam
