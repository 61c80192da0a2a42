#include "services/simulation/scene_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace corbslam {
namespace {

// A placement or cluster that may be seen.
struct Candidate {
  float nearest_m;
  uint32_t index;
};

void SortByDistance(std::vector<Candidate>* candidates) {
  std::sort(candidates->begin(), candidates->end(), [](const Candidate& a, const Candidate& b) {
    return a.nearest_m != b.nearest_m ? a.nearest_m < b.nearest_m : a.index < b.index;
  });
}

// The half spaces within which a camera sees, through its own centre.
class Frustum {
 public:
  explicit Frustum(const Camera& camera)
      : sides_{Side({camera.fx_px, 0, camera.cx_px + 0.5}),
               Side({-camera.fx_px, 0, camera.width_px - 0.5 - camera.cx_px}),
               Side({0, camera.fy_px, camera.cy_px + 0.5}),
               Side({0, -camera.fy_px, camera.height_px - 0.5 - camera.cy_px}), Side({0, 0, 1})} {}

  bool Touches(const Eigen::Vector3d& centre, double radius_m) const {
    return std::all_of(sides_.begin(), sides_.end(),
                       [&](const Eigen::Vector3d& side) { return side.dot(centre) > -radius_m; });
  }

 private:
  static Eigen::Vector3d Side(const Eigen::Vector3d& normal) { return normal.normalized(); }
  std::array<Eigen::Vector3d, 5> sides_;
};

PixelFromMesh Projection(const Camera& camera, const Rigid3d& world_from_camera,
                         const Similarity3d& world_from_mesh) {
  Eigen::Matrix3d pixels;
  pixels << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
  const Eigen::Matrix3d camera_from_world =
      world_from_camera.rotation.toRotationMatrix().transpose();
  const Eigen::Matrix3d turned = pixels * camera_from_world;
  PixelFromMesh projection;
  projection.leftCols<3>() =
      (world_from_mesh.scale * turned * world_from_mesh.rotation.toRotationMatrix()).cast<float>();
  projection.col(3) =
      (turned * (world_from_mesh.translation - world_from_camera.translation)).cast<float>();
  return projection;
}

// Draws the clusters that aren't hidden, near ones first.
void DrawMesh(const FaceMesh& mesh, const PixelFromMesh& projection, uint32_t placement,
              SceneView* view) {
  VisibilityBuffer& buffer = view->buffer;
  std::vector<Candidate> candidates;
  std::vector<SeenBox> boxes;
  for (uint32_t i = 0; i < mesh.clusters.size(); ++i) {
    const auto box =
        SeeBox(mesh.clusters[i].bounds, projection, buffer.width_px(), buffer.height_px());
    if (!box.has_value()) continue;
    candidates.push_back({1 / box->nearness, i});
    boxes.resize(mesh.clusters.size());
    boxes[i] = *box;
  }
  SortByDistance(&candidates);
  for (const Candidate& candidate : candidates) {
    const SeenBox& box = boxes[candidate.index];
    if (buffer.IsHidden(box.rect, box.nearness)) continue;
    DrawCluster(mesh, mesh.clusters[candidate.index], projection, placement, &buffer, &view->drawn);
  }
}

}  // namespace

SceneFaces::SceneFaces(const Scene& scene)
    : movers_(scene.movers), light_(scene.light), seed_(scene.seed) {
  meshes_.reserve(scene.meshes.size());
  for (const Mesh& mesh : scene.meshes) meshes_.push_back(MakeFaceMesh(mesh));
  placements_.reserve(scene.instances.size());
  for (const Instance& instance : scene.instances) {
    placements_.push_back(Place(instance.mesh, instance.world_from_mesh, instance.seed));
  }
}

FacePlacement SceneFaces::Place(uint32_t mesh, const Similarity3d& world_from_mesh,
                                uint32_t seed) const {
  constexpr uint32_t kSpread = 0x9E3779B1U;
  FacePlacement placement{.mesh = mesh, .world_from_mesh = world_from_mesh, .seed = seed * kSpread};
  const Eigen::AlignedBox3f& bounds = meshes_[mesh].bounds;
  if (bounds.isEmpty()) return placement;
  placement.centre = world_from_mesh * bounds.center().cast<double>();
  placement.radius_m = world_from_mesh.scale * 0.5 * bounds.diagonal().norm();
  return placement;
}

SceneView SceneFaces::See(const Camera& camera, const Rigid3d& world_from_camera, double time_s,
                          std::vector<SampleOffset> samples) const {
  SceneView view{.camera = camera,
                 .world_from_camera = world_from_camera,
                 .buffer = {camera.width_px, camera.height_px, std::move(samples)},
                 .drawn = {},
                 .movers = {}};
  for (const Mover& mover : movers_) {
    const Rigid3d pose = corbslam::PoseAt(mover, time_s);
    view.movers.push_back(Place(mover.mesh, Similarity3d::FromRigid(pose), mover.seed));
  }
  const Frustum frustum(camera);
  const Rigid3d camera_from_world = world_from_camera.Inverse();
  std::vector<Candidate> candidates;
  const auto consider = [&](const FacePlacement& placement, size_t index) {
    const Eigen::Vector3d centre = camera_from_world * placement.centre;
    if (!frustum.Touches(centre, placement.radius_m)) return;
    candidates.push_back(
        {static_cast<float>(centre.norm() - placement.radius_m), static_cast<uint32_t>(index)});
  };
  for (size_t i = 0; i < placements_.size(); ++i) consider(placements_[i], i);
  for (size_t i = 0; i < view.movers.size(); ++i) {
    consider(view.movers[i], placements_.size() + i);
  }
  SortByDistance(&candidates);
  for (const Candidate& candidate : candidates) {
    const FacePlacement& placement = PlacementAt(view, candidate.index);
    const FaceMesh& mesh = meshes_[placement.mesh];
    const PixelFromMesh projection =
        Projection(camera, world_from_camera, placement.world_from_mesh);
    const auto box =
        SeeBox(mesh.bounds, projection, view.buffer.width_px(), view.buffer.height_px());
    if (!box.has_value() || view.buffer.IsHidden(box->rect, box->nearness)) continue;
    DrawMesh(mesh, projection, candidate.index, &view);
  }
  return view;
}

}  // namespace corbslam
