// What the builders of a street share: where things may stand and what has been built.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_SITE_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_SITE_H_

#include <Eigen/Core>
#include <cstdint>

#include "services/simulation/dice.h"
#include "services/simulation/scene.h"
#include "services/simulation/worlds/footprints.h"
#include "services/simulation/worlds/scene_chunks.h"
#include "services/simulation/worlds/street_ground.h"
#include "services/simulation/worlds/street_path.h"
#include "services/simulation/worlds/street_world.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// Keeps the random numbers of different things apart.
enum class StreetDice : uint64_t {
  kGround = 1,
  kBlock,
  kHouse,
  kBackHouse,
  kGarage,
  kBorder,
  kCar,
  kTree,
  kGarden,
  kPole,
  kRoad,
  kTraffic,
  kPrototypes,
};

struct StreetSite {
  StreetSite(const StreetPath& path_of_site, const StreetOptions& options_of_site)
      : options(options_of_site), path(path_of_site), ground(path), footprints(path) {}

  const StreetOptions options;
  const StreetPath& path;
  const StreetGround ground;
  Footprints footprints;
  SceneChunks chunks;
  Scene scene;

  Dice DiceFor(StreetDice purpose, int64_t a, int64_t b = 0) const {
    return Dice::For(options.seed, static_cast<uint64_t>(purpose), a, b);
  }
  // Returns which of the few things a look-alike street repeats; in other streets each thing is its
  // own kind.
  int64_t Kind(int64_t number) const { return options.look_alike ? number % 4 : number; }

  Eigen::Vector3d Foot(const Eigen::Vector2d& at) const {
    return {at.x(), ground.GroundY(at), at.y()};
  }
  void Place(uint32_t mesh, const Eigen::Vector2d& at, const Eigen::Vector2d& ahead, double scale,
             uint32_t seed);
  uint32_t AddMesh(Mesh mesh);
  // Adds to the mesh of the place what was built at the origin.
  void Build(const Mesh& mesh, const Eigen::Vector3d& at, const Eigen::Vector2d& ahead);
};

// A hundred metres of street have a character of their own.
struct StreetBlock {
  double setback_m = 8;  // Distance of the houses' fronts from the path on its right.
  double gap_low_m = 2;  // Least gap between houses.
  double gap_high_m = 6;
  double width_low_m = 9;  // Least width of houses.
  double width_high_m = 16;
  double parked_right = 0.5;  // Share of places where a car is parked.
  double parked_left = 0.5;
  bool bays_left = false;  // Cars stand across the street in bays.
  double tree_spacing_m = 10;
  double border = 0.6;  // Share of front gardens with a hedge, wall or fence.
  bool middle_line = false;
};
StreetBlock BlockAt(const StreetSite& site, const Station& station);

// Returns a place beside the station, `lateral_m` to the right of the path (negative: left).
Eigen::Vector2d Beside(const Station& station, double lateral_m);

// Returns where `middle_m` from the street's middle is on a side (1: right, -1: left), from the
// path.
double LateralOf(int side, double middle_m);

// The builders are listed in the order in which they take their places.
void BuildFrontHouses(StreetSite* site);
void ParkCars(StreetSite* site);
void BuildGarages(StreetSite* site);
void BuildBackHouses(StreetSite* site);
void BuildBorders(StreetSite* site);
void PutUpPoles(StreetSite* site);
void PlantTrees(StreetSite* site);
void PaintRoad(StreetSite* site);
void DriveMovers(const std::vector<Rigid3d>& world_from_camera, StreetSite* site);

// Returns a car's pose on the slope of the road.
Rigid3d OnRoad(const StreetGround& ground, const Eigen::Vector2d& at, const Eigen::Vector2d& ahead);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_SITE_H_
