#include <gtest/gtest.h>

#include <vector>

#include "services/simulation/dice.h"
#include "services/simulation/face_mesh.h"
#include "services/simulation/rasteriser.h"
#include "slam/util/checksum.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

// Makes parallelograms by sums of random numbers alone, which are the same on every processor.
Mesh RandomParallelograms(int count) {
  Dice dice(21);
  const auto draw = [&](double reach) {
    return Vector3f{dice.Uniformf(-reach, reach), dice.Uniformf(-reach, reach),
                    dice.Uniformf(-reach, reach)};
  };
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    Patch patch = Rectangle({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, Material::kBrick, 1);
    const double size = dice.Chance(0.01) ? 5 : 0.4;
    const Vector3f corner = Vector3f(0, 0, 6) + draw(14);
    const Vector3f u = draw(size);
    const Vector3f v = draw(size);
    patch.corners = {corner, corner + u, corner + u + v, corner + v};
    mesh.patches.push_back(patch);
  }
  return mesh;
}

uint32_t ChecksumOf(const VisibilityBuffer& buffer, const std::vector<DrawnFace>& drawn) {
  uint32_t checksum = 0;
  const auto extend = [&](const void* data, size_t size) {
    checksum = ExtendCrc32c(checksum, {static_cast<const char*>(data), size});
  };
  const auto columns = static_cast<size_t>(buffer.width_px());
  for (size_t sample = 0; sample < buffer.samples().size(); ++sample) {
    for (int y = 0; y < buffer.height_px(); ++y) {
      extend(buffer.Nearness(sample, y), columns * sizeof(float));
      extend(buffer.Faces(sample, y), columns * sizeof(int32_t));
    }
  }
  for (const DrawnFace& face : drawn) extend(face.nearness.data(), 3 * sizeof(float));
  return checksum;
}

// The checksum was taken on x86-64 with AVX2. Another processor, or another way to arrange the
// arithmetic, must give the same bits.
TEST(RasteriserBitsTest, AreTheSameOnEveryProcessor) {
  PixelFromMesh projection;
  projection << 60, 0, 40.25F, 0.3F, 0, 55, 29.5F, -0.2F, 0, 0.02F, 1, 0.1F;
  const FaceMesh mesh = MakeFaceMesh(RandomParallelograms(2000));
  VisibilityBuffer buffer(83, 61, {{-0.25F, 0.125F}, {0.375F, -0.25F}});
  std::vector<DrawnFace> drawn;
  for (const FaceCluster& cluster : mesh.clusters) {
    DrawCluster(mesh, cluster, projection, 0, &buffer, &drawn);
  }
  EXPECT_GT(drawn.size(), 200U);
  EXPECT_EQ(ChecksumOf(buffer, drawn), 0xac8aaf03u);
}

}  // namespace
}  // namespace corbslam
