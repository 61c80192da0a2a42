#include "services/simulation/worlds/street_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "services/simulation/worlds/footprints.h"
#include "services/simulation/worlds/street_ground.h"
#include "services/simulation/worlds/street_path.h"
#include "services/simulation/worlds/street_site.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Rigid3d PoseTowards(const Vector3d& at, double yaw_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3d::UnitY())), at};
}

// The path goes round a block twice and a half, 0.8 m a frame, uphill on one side; the second time
// `drift_m` higher (y is down) and half a metre to the side.
std::vector<Rigid3d> RoundTheBlock(double drift_m) {
  std::vector<Rigid3d> poses;
  const double side = 90;
  const double corner = 8;
  Vector2d at(0, 0);
  double yaw = 0;
  double along = 0;
  const auto step = [&](double length, double turn) {
    yaw += turn;
    at += length * Vector2d(std::sin(yaw), std::cos(yaw));
    along += length;
    const bool again = poses.size() > 460;
    const double rise = 2 * std::sin(at.y() / 40);
    poses.push_back(
        PoseTowards({at.x() + (again ? 0.5 : 0), -rise - (again ? drift_m : 0), at.y()}, yaw));
  };
  for (int turn = 0; turn < 10; ++turn) {
    for (double way = 0; way < side; way += 0.8) step(0.8, 0);
    const int steps = static_cast<int>(corner * std::numbers::pi / 2 / 0.8);
    for (int i = 0; i < steps; ++i) step(0.8, std::numbers::pi / 2 / steps);
  }
  return poses;
}

// Returns the distance from a point to a patch along a ray, if it hits.
double HitDistance(const Patch& patch, const Rigid3d& world_from_mesh, double scale,
                   const Vector3d& from, const Vector3d& direction) {
  std::array<Vector3d, 4> corners;
  for (size_t i = 0; i < 4; ++i) {
    corners[i] = world_from_mesh * (scale * patch.corners[i].cast<double>());
  }
  for (const auto& [b, c] : {std::pair<size_t, size_t>(1, 2), std::pair<size_t, size_t>(2, 3)}) {
    // The intersection is Möller and Trumbore's.
    const Vector3d e1 = corners[b] - corners[0];
    const Vector3d e2 = corners[c] - corners[0];
    const Vector3d p = direction.cross(e2);
    const double determinant = e1.dot(p);
    if (std::abs(determinant) < 1e-12) continue;
    const Vector3d s = from - corners[0];
    const double u = s.dot(p) / determinant;
    const Vector3d q = s.cross(e1);
    const double v = direction.dot(q) / determinant;
    const double t = e2.dot(q) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1 && t > 0) return t;
  }
  return std::numeric_limits<double>::max();
}

// Calls `visit` with every patch whose mesh's bounds come within `reach_m` of the place.
template <typename Visit>
void VisitPatches(const Scene& scene, const Vector3d& at, double reach_m, Visit visit) {
  for (const Instance& instance : scene.instances) {
    const Rigid3d pose = {instance.world_from_mesh.rotation, instance.world_from_mesh.translation};
    const double scale = instance.world_from_mesh.scale;
    for (const Patch& patch : scene.meshes[instance.mesh].patches) {
      const Vector3d corner = pose * (scale * patch.corners[0].cast<double>());
      if ((corner - at).norm() < reach_m) visit(patch, pose, scale);
    }
  }
}

// A patch is at most this large.
constexpr double kLargestPatchM = 36;

double FirstHit(const Scene& scene, const Vector3d& from, const Vector3d& direction,
                double reach_m) {
  double nearest = std::numeric_limits<double>::max();
  VisitPatches(scene, from, kLargestPatchM + reach_m,
               [&](const Patch& patch, const Rigid3d& pose, double scale) {
                 nearest = std::min(nearest, HitDistance(patch, pose, scale, from, direction));
               });
  return nearest;
}

uint64_t Fingerprint(const Scene& scene) {
  uint64_t hash = 14695981039346656037ULL;
  const auto add = [&](const void* data, size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ULL;
  };
  for (const Mesh& mesh : scene.meshes) {
    for (const Patch& patch : mesh.patches) {
      add(patch.corners.data(), sizeof(patch.corners));
      add(&patch.seed, sizeof(patch.seed));
      add(&patch.u_offset_m, sizeof(patch.u_offset_m));
      add(&patch.tone, sizeof(patch.tone));
    }
  }
  for (const Instance& instance : scene.instances) {
    add(&instance.mesh, sizeof(instance.mesh));
    add(&instance.seed, sizeof(instance.seed));
    add(instance.world_from_mesh.translation.data(), 3 * sizeof(double));
  }
  for (const Mover& mover : scene.movers) {
    for (const Mover::Waypoint& at : mover.path) {
      add(&at.time_s, sizeof(at.time_s));
      add(at.world_from_mesh.translation.data(), 3 * sizeof(double));
    }
  }
  return hash;
}

TEST(StreetWorld, TheWayAheadIsFreeAndTheGroundBelow) {
  const std::vector<Rigid3d> poses = RoundTheBlock(0.7);
  const Scene scene = BuildStreetScene(poses, {});
  for (size_t i = 0; i < poses.size(); i += 97) {
    const Vector3d at = poses[i].translation;
    const Vector3d ahead = poses[i].rotation * Vector3d::UnitZ();
    EXPECT_GT(FirstHit(scene, at, ahead, 2), 1.2) << "pose " << i;
    for (const double x : {-0.4, 0.0, 0.4}) {
      const Vector3d aside = poses[i].rotation * Vector3d(x, -0.1, 1).normalized();
      EXPECT_GT(FirstHit(scene, at, aside, 2), 1.2) << "pose " << i << " aside " << x;
    }
    const double below = FirstHit(scene, at, Vector3d::UnitY(), 3);
    EXPECT_GE(below, 1.15) << "pose " << i;
    EXPECT_LE(below, 2.2) << "pose " << i;
  }
}

TEST(StreetWorld, NothingReachesIntoTheCorridorOfAnyPass) {
  const std::vector<Rigid3d> poses = RoundTheBlock(0.3);
  const Scene scene = BuildStreetScene(poses, {});
  const StreetPath path(poses);
  const StreetGround ground(path);
  // Counts corners of whatever stands within a metre of the path, higher than a kerb and lower than
  // crowns and lamps.
  int wrong = 0;
  for (const Instance& instance : scene.instances) {
    for (const Patch& patch : scene.meshes[instance.mesh].patches) {
      for (const Eigen::Vector3f& corner : patch.corners) {
        const Vector3d at = instance.world_from_mesh * corner.cast<double>();
        const Vector2d plane(at.x(), at.z());
        if (path.Distance(plane, 1.5) >= 1.5) continue;
        const double height = ground.RoadY(plane) - at.y();
        if (height > 0.2 && height < 2) ++wrong;
      }
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST(StreetWorld, FollowsTheSeedAndNothingElse) {
  const std::vector<Rigid3d> poses = RoundTheBlock(0.2);
  StreetOptions options;
  options.moving_cars = 6;
  const uint64_t first = Fingerprint(BuildStreetScene(poses, options));
  EXPECT_EQ(Fingerprint(BuildStreetScene(poses, options)), first);
  options.seed = 2;
  EXPECT_NE(Fingerprint(BuildStreetScene(poses, options)), first);
}

TEST(StreetWorld, NoTwoThingsStandOnOnePlace) {
  const std::vector<Rigid3d> poses = RoundTheBlock(0.2);
  const StreetPath path(poses);
  StreetSite site(path, {});
  BuildFrontHouses(&site);
  const size_t houses = site.footprints.taken().size();
  EXPECT_GT(houses, 20U);
  ParkCars(&site);
  BuildGarages(&site);
  BuildBackHouses(&site);
  BuildBorders(&site);
  PutUpPoles(&site);
  PlantTrees(&site);
  const std::vector<Footprint>& taken = site.footprints.taken();
  EXPECT_GT(taken.size(), houses + 100);
  for (size_t i = 0; i < taken.size(); ++i) {
    for (size_t j = i + 1; j < taken.size(); ++j) {
      ASSERT_FALSE(Overlap(taken[i], taken[j])) << i << " and " << j;
    }
    for (const Station& station : path.stations()) {
      ASSERT_GT(DistanceTo(taken[i], station.at), i < houses ? 6.3 : 1.8) << i;
    }
  }
}

TEST(StreetWorld, MoversKeepTheirDistance) {
  const std::vector<Rigid3d> poses = RoundTheBlock(0.2);
  StreetOptions options;
  options.moving_cars = 10;
  const Scene scene = BuildStreetScene(poses, options);
  EXPECT_GE(scene.movers.size(), 3U);
  double nearest = std::numeric_limits<double>::max();
  for (const Mover& mover : scene.movers) {
    for (size_t i = 0; i < poses.size(); ++i) {
      const double time_s = static_cast<double>(i) / options.frame_rate_hz;
      const Rigid3d at = PoseAt(mover, time_s);
      const Vector3d eye = at.Inverse() * poses[i].translation;
      for (const Patch& patch : scene.meshes[mover.mesh].patches) {
        for (const Eigen::Vector3f& corner : patch.corners) {
          nearest = std::min(nearest, (corner.cast<double>() - eye).norm());
        }
      }
    }
  }
  EXPECT_GT(nearest, 1.5);
  EXPECT_LT(nearest, 8);  // Robot and movers do meet.
}

TEST(StreetWorld, EveryNumberIsFinite) {
  const Scene scene = BuildStreetScene(RoundTheBlock(0.9), {.seed = 5, .moving_cars = 3});
  for (const Mesh& mesh : scene.meshes) {
    for (const Patch& patch : mesh.patches) {
      for (const Eigen::Vector3f& corner : patch.corners) ASSERT_TRUE(corner.allFinite());
      ASSERT_NEAR(patch.u_axis.norm(), 1, 1e-3);
      ASSERT_NEAR(patch.v_axis.norm(), 1, 1e-3);
      ASSERT_TRUE(std::isfinite(patch.u_offset_m) && std::isfinite(patch.v_offset_m));
      ASSERT_GE(patch.tone, 0);
    }
  }
}

TEST(StreetWorld, ShortPathsHaveWorlds) {
  EXPECT_TRUE(BuildStreetScene({}, {}).instances.empty());
  const Scene one = BuildStreetScene({Rigid3d::Identity()}, {.moving_cars = 2});
  EXPECT_FALSE(one.instances.empty());
  EXPECT_NEAR(FirstHit(one, Vector3d::Zero(), Vector3d::UnitY(), 3), 1.65, 0.05);
}

TEST(StreetWorld, LookAlikeStreetsRepeatTheirHouses) {
  const std::vector<Rigid3d> poses = RoundTheBlock(0);
  const auto walls = [&](bool look_alike) {
    std::vector<uint32_t> seeds;
    const Scene scene = BuildStreetScene(poses, {.look_alike = look_alike});
    for (const Mesh& mesh : scene.meshes) {
      for (const Patch& patch : mesh.patches) {
        if (patch.material == Material::kDoor) seeds.push_back(patch.seed);
      }
    }
    std::sort(seeds.begin(), seeds.end());
    const auto last = std::unique(seeds.begin(), seeds.end());
    return static_cast<double>(last - seeds.begin()) / static_cast<double>(seeds.size());
  };
  EXPECT_GT(walls(false), 2 * walls(true));
}

}  // namespace
}  // namespace corbslam
