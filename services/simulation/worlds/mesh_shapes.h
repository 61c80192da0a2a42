// Adds simple shapes to meshes. Frames are as in scene.h: y runs down, so a box's top has the least
// y.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_MESH_SHAPES_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_MESH_SHAPES_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "services/simulation/scene.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// What a shape is made of.
struct Finish {
  Material material = Material::kPlaster;
  uint32_t seed = 0;
  float tone = 1;
};

// Adds corners in order round, in one plane; the texture has its origin at `a`, u towards `b`. A
// triangle has `d` == `c`.
void AddQuad(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
             const Eigen::Vector3f& d, const Finish& finish, Mesh* mesh);

// Adds a flat convex polygon of at least three corners, as quads; its texture is laid as in
// AddQuad.
void AddPolygon(const std::vector<Eigen::Vector3f>& corners, const Finish& finish, Mesh* mesh);

// Adds sides and top, each with its own pattern; the bottom too if it can be seen.
void AddBox(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const Finish& finish,
            Mesh* mesh, bool bottom = false);

// Adds the sides of a prism that tapers from one radius to the other.
void AddTube(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float from_radius,
             float to_radius, int sides, const Finish& finish, Mesh* mesh);

// Adds a regular octagon across `normal`.
void AddDisc(const Eigen::Vector3f& centre, const Eigen::Vector3f& normal, float radius,
             const Finish& finish, Mesh* mesh);

// Adds `mesh` moved by `to_from_mesh`, textures with it.
void AppendMoved(const Mesh& mesh, const Rigid3d& to_from_mesh, Mesh* to);

// Returns the pose of a mesh that stands upright at `origin` and whose z axis points along `ahead`
// (x, z).
Rigid3d Upright(const Eigen::Vector3d& origin, const Eigen::Vector2d& ahead);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_MESH_SHAPES_H_
