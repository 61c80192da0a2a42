// A simulated world as plain data: flat patches with procedural surfaces, gathered into meshes that
// are placed once (the ground, a house), many times (a tree) or move (a car).
//
// The world's frame is the one of the KITTI ground truth: x right, y DOWN, z forward, metres.
#ifndef CORBSLAM_SERVICES_SIMULATION_SCENE_H_
#define CORBSLAM_SERVICES_SIMULATION_SCENE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "slam/geometry/rigid3.h"

namespace corbslam {

// What a patch looks like; surface_patterns.h says how each is drawn.
enum class Material : uint8_t {
  kAsphalt,
  kPavement,  // slabs
  kGrass,
  kPlaster,  // a wall without windows
  kBrick,
  kFacade,  // storeys of windows in plaster or brick; v runs downward from the eaves
  kRoofTiles,
  kDoor,
  kWood,  // planks of a fence, vertical
  kHedge,
  kBark,
  kLeaves,  // a clump of leaves
  kMetal,   // poles, frames
  kCarPaint,
  kGlass,  // car and shop windows
  kTyre,
  kRoadMarking,
  kSign,        // a shield or poster with print on it
  kWallpaper,   // indoors
  kFloorTiles,  // indoors
  kCarpet,      // indoors
  kShelf,       // indoors: boards with books
  kCeiling,     // indoors: panels
  kSky,         // what is seen where no patch is
};

// A flat convex quadrilateral, seen from both sides.
struct Patch {
  std::array<Eigen::Vector3f, 4> corners;  // The corners in order round.
  // Texture coordinates in metres of a point x of the mesh's frame:
  // u = u_axis . x + u_offset_m, v = v_axis . x + v_offset_m; the axes are unit vectors.
  Eigen::Vector3f u_axis;
  Eigen::Vector3f v_axis;
  float u_offset_m = 0;
  float v_offset_m = 0;
  Material material = Material::kPlaster;
  uint32_t seed = 0;  // Patches with the same seed and material share one endless pattern.
  float tone = 1;     // Multiplies the reflectance, 0 to 1.5.
};

// Returns the patch with corners origin, +u, +u+v, +v and texture axes along its edges, texture
// origin at `origin`.
Patch Rectangle(const Eigen::Vector3f& origin, const Eigen::Vector3f& edge_u,
                const Eigen::Vector3f& edge_v, Material material, uint32_t seed, float tone = 1);

struct Mesh {
  std::vector<Patch> patches;
};

// A mesh placed in the world. Its seed is mixed into those of its patches, so that two trees of one
// mesh differ in their surface.
struct Instance {
  uint32_t mesh = 0;  // Index into Scene::meshes.
  Similarity3d world_from_mesh = {};
  uint32_t seed = 0;
};

// A mesh that moves along a timed path: at rest before the first time and after the last,
// interpolated linearly between.
struct Mover {
  struct Waypoint {
    double time_s = 0;
    Rigid3d world_from_mesh;
  };
  uint32_t mesh = 0;
  uint32_t seed = 0;
  std::vector<Waypoint> path = {};  // It has at least one, and times grow.
};

// Returns where a mover is at a time of the sequence.
Rigid3d PoseAt(const Mover& mover, double time_s);

struct Light {
  // Unit vector that points from the world to the sun.
  Eigen::Vector3f towards_sun = Eigen::Vector3f(-0.45F, -0.75F, 0.48F);
  float ambient = 0.55F;  // Share of light that comes from everywhere, 0 to 1.
  bool sky = true;        // False: indoors, what no patch covers is black.
};

struct Scene {
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<Mover> movers;
  Light light;
  uint32_t seed = 1;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SCENE_H_
