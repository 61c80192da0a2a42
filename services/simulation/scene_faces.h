// A scene made ready for drawing, and what a camera sees of it.
#ifndef CORBSLAM_SERVICES_SIMULATION_SCENE_FACES_H_
#define CORBSLAM_SERVICES_SIMULATION_SCENE_FACES_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "services/simulation/face_mesh.h"
#include "services/simulation/rasteriser.h"
#include "services/simulation/scene.h"
#include "services/simulation/visibility_buffer.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// A mesh at its place in the scene.
struct FacePlacement {
  uint32_t mesh = 0;
  Similarity3d world_from_mesh = {};
  uint32_t seed = 0;
  Eigen::Vector3d centre = {};  // Centre of a ball round it.
  double radius_m = 0;
};

// What is seen at each sample of a picture.
struct SceneView {
  Camera camera;
  Rigid3d world_from_camera;
  VisibilityBuffer buffer;  // Its faces are indices into `drawn`.
  std::vector<DrawnFace> drawn;
  // Placements of movers; their numbers go on after those that stand still.
  std::vector<FacePlacement> movers;
};

// Immutable; See may be called from any thread.
class SceneFaces {
 public:
  explicit SceneFaces(const Scene& scene);

  // The movers are where they are at `time_s` of the sequence.
  SceneView See(const Camera& camera, const Rigid3d& world_from_camera, double time_s,
                std::vector<SampleOffset> samples) const;

  // `index` is a DrawnFace::placement.
  const FacePlacement& PlacementAt(const SceneView& view, uint32_t index) const {
    const size_t still = placements_.size();
    return index < still ? placements_[index] : view.movers[index - still];
  }
  const PatchSurface& SurfaceOf(const SceneView& view, const DrawnFace& face) const {
    return meshes_[PlacementAt(view, face.placement).mesh].surfaces[face.patch];
  }
  const Light& light() const { return light_; }
  uint32_t seed() const { return seed_; }

 private:
  FacePlacement Place(uint32_t mesh, const Similarity3d& world_from_mesh, uint32_t seed) const;

  std::vector<FaceMesh> meshes_;
  std::vector<FacePlacement> placements_;
  std::vector<Mover> movers_;
  Light light_;
  uint32_t seed_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SCENE_FACES_H_
