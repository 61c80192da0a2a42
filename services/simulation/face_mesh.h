// A mesh made ready for drawing: faces eight at a time, gathered into clusters that lie together.
#ifndef CORBSLAM_SERVICES_SIMULATION_FACE_MESH_H_
#define CORBSLAM_SERVICES_SIMULATION_FACE_MESH_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "services/simulation/eight.h"
#include "services/simulation/scene.h"

namespace corbslam {

// Eight flat convex faces in the mesh's frame, metres: corners in order round, a triangle's last
// one twice.
struct FaceGroup {
  std::array<Eight<float>, 4> x;
  std::array<Eight<float>, 4> y;
  std::array<Eight<float>, 4> z;
  Eight<uint32_t> patch;  // Index into FaceMesh::surfaces.
  size_t count = 0;       // Lanes from here on repeat the last face.
};

struct FaceCluster {
  Eigen::AlignedBox3f bounds;
  uint32_t first_group = 0;
  uint32_t group_count = 0;
};

// What shading needs of a patch, in the mesh's frame.
struct PatchSurface {
  Eigen::Vector3f u_axis;
  Eigen::Vector3f v_axis;
  Eigen::Vector3f normal;
  float u_offset_m;
  float v_offset_m;
  float tone;
  uint32_t seed;
  Material material;
};

struct FaceMesh {
  std::vector<FaceGroup> groups;
  std::vector<FaceCluster> clusters;
  std::vector<PatchSurface> surfaces;  // One surface for each patch of the mesh.
  Eigen::AlignedBox3f bounds;
};

// Patches that aren't quite flat or convex become two triangles each.
FaceMesh MakeFaceMesh(const Mesh& mesh);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_FACE_MESH_H_
