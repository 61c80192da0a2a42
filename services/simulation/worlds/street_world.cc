#include "services/simulation/worlds/street_world.h"

#include <utility>

#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

constexpr float kAmbient = 0.3F;  // The ambient light of a sunny day.

}  // namespace

Scene BuildStreetScene(const std::vector<Rigid3d>& world_from_camera,
                       const StreetOptions& options) {
  if (world_from_camera.empty()) return {};
  const StreetPath path(world_from_camera);
  StreetSite site(path, options);
  site.scene.seed = static_cast<uint32_t>(options.seed);
  site.scene.light.ambient = kAmbient;
  site.ground.AddTo(site.DiceFor(StreetDice::kGround, 0).Next(), &site.chunks);
  BuildFrontHouses(&site);
  ParkCars(&site);
  BuildGarages(&site);
  BuildBackHouses(&site);
  BuildBorders(&site);
  PutUpPoles(&site);
  PlantTrees(&site);
  PaintRoad(&site);
  DriveMovers(world_from_camera, &site);
  site.chunks.MoveInto(&site.scene);
  return std::move(site.scene);
}

}  // namespace corbslam
