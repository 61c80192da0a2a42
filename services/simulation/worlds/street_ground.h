// Makes the ground along the streets: carriageway, kerb, pavement and the gardens' soil.
//
// Where the carriageway lies is a field of distances to the middle of all streets, so that
// crossings and streets driven several times join without seams. Heights are linear over the
// triangles of a lattice, so that pieces of different size meet without cracks.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_GROUND_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_GROUND_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "services/simulation/worlds/scene_chunks.h"
#include "services/simulation/worlds/street_path.h"

namespace corbslam {

// The street's cross-section in metres. Left and right are those of the direction of travel.
struct StreetProfile {
  static constexpr double kMiddleLeftOfPath = 1.0;
  static constexpr double kKerb = 4.2;  // Distance from the middle to the kerb.
  static constexpr double kKerbStone = 0.18;
  static constexpr double kPavement = 6.6;  // Distance from the middle to the pavement's far edge.
  static constexpr double kKerbHeight = 0.12;
};

// Immutable after construction; thread-safe.
class StreetGround {
 public:
  explicit StreetGround(const StreetPath& path);

  // Returns the height (y, down) of the carriageway's level at (x, z).
  double RoadY(const Eigen::Vector2d& at) const;
  // Returns the height of what is there to stand on.
  double GroundY(const Eigen::Vector2d& at) const;
  // Returns the distance to the nearest street's middle; at most kFarM.
  double MiddleDistance(const Eigen::Vector2d& at) const;

  void AddTo(uint64_t seed, SceneChunks* chunks) const;

  static constexpr double kFarM = 12;

 private:
  static constexpr double kCellM = 4;
  static constexpr int kFine = 2;  // Fine cells along a coarse one.
  static constexpr double kFineM = kCellM / kFine;
  static constexpr int kHeadings = 6;

  struct Corner {
    Eigen::Vector3f at;
    float middle_m = 0;
  };
  // What the patches of one cell have in common.
  struct Soil {
    uint64_t seed = 0;
    int heading = 0;
  };

  void MeasureMiddles(const StreetPath& path);
  void MeasureHeights(const StreetPath& path);

  // Returns a corner of the fine lattice.
  Corner CornerAt(int fine_x, int fine_z) const;
  void AddCell(int cell_x, int cell_z, uint64_t seed, Mesh* mesh) const;
  static void AddTriangle(const std::vector<Corner>& triangle, const Soil& soil, Mesh* mesh);
  static void AddLevel(const std::vector<Corner>& polygon, Material material, const Soil& soil,
                       float raised_m, Mesh* mesh);
  static void AddKerb(const std::vector<Corner>& polygon, const Soil& soil, Mesh* mesh);

  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int cells_x_ = 0;  // Number of cells of the coarse lattice.
  int cells_z_ = 0;
  std::vector<float> height_;    // y at the coarse lattice's corners, NaN far from any street.
  std::vector<float> middle_m_;  // Distances at the fine lattice's corners.
  // Heading of the nearest street there, in sixths of a right angle.
  std::vector<uint8_t> heading_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_STREET_GROUND_H_
