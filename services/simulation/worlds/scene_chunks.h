// Gathers patches of what stands still by place, so that a mesh covers a small part of the world.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_SCENE_CHUNKS_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_SCENE_CHUNKS_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "services/simulation/scene.h"

namespace corbslam {

class SceneChunks {
 public:
  static constexpr double kSizeM = 48;

  // Returns the mesh of the square that (x, z) lies in.
  Mesh* At(const Eigen::Vector2d& at) {
    return &meshes_[{static_cast<int>(std::floor(at.x() / kSizeM)),
                     static_cast<int>(std::floor(at.y() / kSizeM))}];
  }

  // Adds each mesh with one instance where it is.
  void MoveInto(Scene* scene) {
    for (auto& [square, mesh] : meshes_) {
      if (mesh.patches.empty()) continue;
      Instance instance;
      instance.mesh = static_cast<uint32_t>(scene->meshes.size());
      scene->meshes.push_back(std::move(mesh));
      scene->instances.push_back(instance);
    }
    meshes_.clear();
  }

 private:
  std::map<std::pair<int, int>, Mesh> meshes_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_SCENE_CHUNKS_H_
