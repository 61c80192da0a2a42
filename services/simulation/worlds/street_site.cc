#include "services/simulation/worlds/street_site.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "services/simulation/worlds/mesh_shapes.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBlockM = 100;

}  // namespace

uint32_t StreetSite::AddMesh(Mesh mesh) {
  scene.meshes.push_back(std::move(mesh));
  return static_cast<uint32_t>(scene.meshes.size() - 1);
}

void StreetSite::Place(uint32_t mesh, const Vector2d& at, const Vector2d& ahead, double scale,
                       uint32_t seed) {
  Instance instance;
  instance.mesh = mesh;
  instance.world_from_mesh = Similarity3d::FromRigid(Upright(Foot(at), ahead));
  instance.world_from_mesh.scale = scale;
  instance.seed = seed;
  scene.instances.push_back(instance);
}

void StreetSite::Build(const Mesh& mesh, const Vector3d& at, const Vector2d& ahead) {
  AppendMoved(mesh, Upright(at, ahead), chunks.At({at.x(), at.z()}));
}

StreetBlock BlockAt(const StreetSite& site, const Station& station) {
  const auto number = static_cast<int64_t>(std::floor(station.along_m / kBlockM));
  Dice dice = site.DiceFor(StreetDice::kBlock, site.Kind(number), station.driven ? 0 : 1);
  StreetBlock block;
  const bool terraces = dice.Chance(0.35);
  block.setback_m = terraces ? dice.Uniform(6.9, 9.5) : dice.Uniform(7.5, 13);
  block.gap_low_m = terraces ? 0 : 2;
  block.gap_high_m = terraces ? 1.5 : dice.Uniform(4, 9);
  block.width_low_m = terraces ? 8 : 9;
  block.width_high_m = terraces ? 14 : 21;
  block.parked_right = dice.Chance(0.8) ? dice.Uniform(0.25, 0.85) : 0.05;
  block.parked_left = dice.Chance(0.8) ? dice.Uniform(0.25, 0.85) : 0.05;
  block.bays_left = block.setback_m > 8.5 && dice.Chance(0.4);
  block.tree_spacing_m = dice.Chance(0.75) ? dice.Uniform(7, 13) : dice.Uniform(25, 45);
  block.border = dice.Uniform(0.45, 0.95);
  block.middle_line = dice.Chance(0.25);
  return block;
}

Vector2d Beside(const Station& station, double lateral_m) {
  return station.at + lateral_m * station.Right();
}

double LateralOf(int side, double middle_m) {
  return side * middle_m - StreetProfile::kMiddleLeftOfPath;
}

Rigid3d OnRoad(const StreetGround& ground, const Vector2d& at, const Vector2d& ahead) {
  const double reach = 1.4;
  const Vector2d front = at + reach * ahead;
  const Vector2d back = at - reach * ahead;
  const Vector3d slope(front.x() - back.x(), ground.RoadY(front) - ground.RoadY(back),
                       front.y() - back.y());
  Eigen::Matrix3d rotation;
  rotation.col(2) = slope.normalized();
  rotation.col(0) = Vector3d(ahead.y(), 0, -ahead.x());
  rotation.col(1) = rotation.col(2).cross(rotation.col(0));
  return {Eigen::Quaterniond(rotation), {at.x(), ground.RoadY(at), at.y()}};
}

}  // namespace corbslam
