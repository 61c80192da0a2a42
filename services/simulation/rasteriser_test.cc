#include "services/simulation/rasteriser.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "services/simulation/dice.h"
#include "services/simulation/face_mesh.h"
#include "services/simulation/renderer.h"

namespace corbslam {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

Camera TestCamera() {
  return {.fx_px = 60, .fy_px = 55, .cx_px = 40.25, .cy_px = 29.5, .width_px = 83, .height_px = 61};
}

// Flat quadrilaterals of many sizes and ways all round the camera, some of them through it.
std::vector<Patch> RandomPatches(int count, Dice* dice) {
  std::vector<Patch> patches;
  for (int i = 0; i < count; ++i) {
    const auto direction = [&] {
      return Vector3f(dice->Uniformf(-1, 1), dice->Uniformf(-1, 1), dice->Uniformf(-1, 1));
    };
    const Vector3f u = direction();
    const Vector3f v = u.cross(direction());
    const float size = std::pow(10.0F, dice->Uniformf(-1.5, 1.3));
    patches.push_back(Rectangle(12 * direction(), size * u.normalized(),
                                0.7F * size * v.normalized(), Material::kBrick, dice->Seed()));
  }
  return patches;
}

// Depth of a patch along a ray from the origin, and how far within its borders it is met there, as
// a share of its sides; negative outside.
struct Meeting {
  double depth_m;
  double inside;
};
Meeting Meet(const Patch& patch, const Vector3d& ray) {
  const Vector3d corner = patch.corners[0].cast<double>();
  const Vector3d u = (patch.corners[1] - patch.corners[0]).cast<double>();
  const Vector3d v = (patch.corners[3] - patch.corners[0]).cast<double>();
  const Vector3d normal = u.cross(v);
  const double depth = normal.dot(corner) / normal.dot(ray);
  const Vector3d at = depth * ray - corner;
  const double s = at.dot(u) / u.squaredNorm();
  const double t = at.dot(v) / v.squaredNorm();
  return {depth, std::min({s, t, 1 - s, 1 - t})};
}

// What intersecting each ray with each patch finds, without any of the rasteriser's short cuts.
TEST(RasteriserTest, DepthsAreThoseOfRaysAgainstEveryPatch) {
  Dice dice(4);
  const Camera camera = TestCamera();
  for (int round = 0; round < 20; ++round) {
    const std::vector<Patch> patches = RandomPatches(60, &dice);
    Scene scene;
    scene.meshes.push_back({patches});
    scene.instances.push_back({});
    const cv::Mat depth = Renderer(scene).DrawDepth(camera, {});
    for (int y = 0; y < depth.rows; ++y) {
      for (int x = 0; x < depth.cols; ++x) {
        const Vector3d ray((x - camera.cx_px) / camera.fx_px, (y - camera.cy_px) / camera.fy_px, 1);
        double nearest = std::numeric_limits<double>::infinity();
        bool on_border = false;
        for (const Patch& patch : patches) {
          const Meeting meeting = Meet(patch, ray);
          if (meeting.depth_m < 0.051) {
            // Where the nearest depth cuts a patch, either answer is right.
            on_border = on_border || (meeting.inside > 0 && meeting.depth_m > 0.049);
            continue;
          }
          on_border = on_border || std::abs(meeting.inside) < 1e-3;
          if (meeting.inside > 0) nearest = std::min(nearest, meeting.depth_m);
        }
        if (on_border) continue;
        const double expected = std::isinf(nearest) ? 0 : nearest;
        EXPECT_NEAR(depth.at<float>(y, x), expected, 2e-3 * (1 + expected))
            << "round " << round << ", pixel " << x << ", " << y;
      }
    }
  }
}

TEST(RasteriserTest, NeighboursLeaveNoGapsBetweenThem) {
  // A turned wall of a thousand small squares in front of another: the far one is seen nowhere.
  Scene scene;
  Mesh wall;
  const Vector3f u = Vector3f(1, 0.31F, 0.17F).normalized();
  const Vector3f v = u.cross(Vector3f(0.1F, 0.2F, -1)).normalized();
  const auto at = [&](int i, int j) {
    return Vector3f(Vector3f(0, 0, 6) + 0.73F * static_cast<float>(i) * u +
                    0.61F * static_cast<float>(j) * v);
  };
  for (int i = -16; i < 16; ++i) {
    for (int j = -16; j < 16; ++j) {
      Patch patch = Rectangle(at(i, j), u, v, Material::kBrick, 1);
      patch.corners = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
      wall.patches.push_back(patch);
    }
  }
  scene.meshes.push_back(wall);
  scene.instances.push_back({});
  const Renderer renderer(scene);
  for (int i = 0; i < 40; ++i) {
    Shot shot;
    shot.world_from_camera.rotation = Eigen::AngleAxisd(0.02 * i, Vector3d::UnitZ());
    const cv::Mat depth = renderer.DrawDepth(TestCamera(), shot);
    EXPECT_EQ(cv::countNonZero(depth), static_cast<int>(depth.total())) << "turn " << i;
  }
}

TEST(RasteriserTest, ABoxBesideBehindAndAroundTheCamera) {
  PixelFromMesh projection = PixelFromMesh::Zero();
  projection << 60, 0, 40, 0, 0, 60, 30, 0, 0, 0, 1, 0;
  const auto see = [&](const Vector3f& centre, float half) {
    const Vector3f extent(half, half, half);
    return SeeBox({centre - extent, centre + extent}, projection, 81, 61);
  };
  EXPECT_FALSE(see({0, 0, -3}, 1).has_value());
  EXPECT_FALSE(see({30, 0, 10}, 1).has_value());
  EXPECT_FALSE(see({0, -20, 10}, 1).has_value());

  const auto ahead = see({0, 0, 7}, 1);
  ASSERT_TRUE(ahead.has_value());
  EXPECT_FLOAT_EQ(ahead->nearness, 1.0F / 6);
  EXPECT_EQ(ahead->rect.left, 30);
  EXPECT_EQ(ahead->rect.right, 50);
  EXPECT_EQ(ahead->rect.top, 20);
  EXPECT_EQ(ahead->rect.bottom, 40);

  const auto around = see({0, 0, 0}, 1);
  ASSERT_TRUE(around.has_value());
  EXPECT_EQ(around->rect.right, 80);
  EXPECT_FLOAT_EQ(around->nearness, VisibilityBuffer::kMostNearness);
}

TEST(FaceMeshTest, BentAndHollowPatchesBecomeTwoTriangles) {
  Patch bent = Rectangle({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, Material::kBrick, 1);
  bent.corners[2].z() += 0.1F;
  Patch hollow = Rectangle({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, Material::kBrick, 1);
  hollow.corners[2] = {0.2F, 0.2F, 5};
  const Patch flat = Rectangle({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, Material::kBrick, 1);
  EXPECT_EQ(MakeFaceMesh({{flat}}).groups[0].count, 1U);
  EXPECT_EQ(MakeFaceMesh({{bent}}).groups[0].count, 2U);
  EXPECT_EQ(MakeFaceMesh({{hollow}}).groups[0].count, 2U);
}

TEST(FaceMeshTest, EveryFaceIsInOneClusterWithinItsBounds) {
  Dice dice(9);
  const FaceMesh mesh = MakeFaceMesh({RandomPatches(1000, &dice)});
  EXPECT_GT(mesh.clusters.size(), 15U);
  std::vector<int> seen(1000, 0);
  for (const FaceCluster& cluster : mesh.clusters) {
    for (uint32_t i = 0; i < cluster.group_count; ++i) {
      const FaceGroup& group = mesh.groups[cluster.first_group + i];
      for (size_t lane = 0; lane < group.count; ++lane) {
        ++seen[group.patch.lanes[lane]];
        for (size_t k = 0; k < 4; ++k) {
          EXPECT_TRUE(cluster.bounds.contains(
              Vector3f(group.x[k].lanes[lane], group.y[k].lanes[lane], group.z[k].lanes[lane])));
        }
      }
    }
  }
  for (const int count : seen) EXPECT_EQ(count, 1);
}

TEST(VisibilityBufferTest, HiddenIsWhatSomethingNearerCoversEverywhere) {
  VisibilityBuffer buffer(21, 10, {SampleOffset(), SampleOffset{0.25F, 0.25F}});
  const PixelRect all = {0, 20, 0, 9};
  EXPECT_FALSE(buffer.IsHidden(all, 0.5F));
  for (size_t sample = 0; sample < 2; ++sample) {
    for (int y = 0; y < 10; ++y) {
      for (int block = 0; block < 3; ++block) buffer.NearnessRow(sample, y)[block].lanes.fill(1);
    }
  }
  buffer.MarkChanged(all);
  EXPECT_TRUE(buffer.IsHidden(all, 0.5F));
  EXPECT_FALSE(buffer.IsHidden(all, 1.5F));
  buffer.NearnessRow(1, 9)[2].lanes[0] = 0.1F;
  buffer.MarkChanged({16, 20, 9, 9});
  EXPECT_FALSE(buffer.IsHidden(all, 0.5F));
  EXPECT_TRUE(buffer.IsHidden({0, 15, 0, 9}, 0.5F));
  EXPECT_TRUE(buffer.IsKnownHidden({0, 15, 0, 9}, 0.5F));
}

}  // namespace
}  // namespace corbslam
