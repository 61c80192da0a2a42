#include "services/simulation/rasteriser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "services/simulation/lanes.h"

namespace corbslam {
namespace {

constexpr float kNearestDepth_m = 1 / VisibilityBuffer::kMostNearness;

// Holds linear functions of a pixel's place, a x + b y + c: one for each side of a face, not
// negative within; and the face's nearness.
struct FaceLanes {
  std::array<Floats, 4> a, b, c;
  Floats near_a, near_b, near_c;
  Ints left, right, top, bottom;
  Floats nearest;  // Nearness of the nearest corner.
};

struct Corner {
  Floats x, y, z;  // Depth times the pixel's place and 1.
};

CORBSLAM_LANES Corner Project(const FaceGroup& group, size_t k, const PixelFromMesh& m) {
  const Floats x = Load(group.x[k]);
  const Floats y = Load(group.y[k]);
  const Floats z = Load(group.z[k]);
  return {m(0, 0) * x + m(0, 1) * y + m(0, 2) * z + m(0, 3),
          m(1, 0) * x + m(1, 1) * y + m(1, 2) * z + m(1, 3),
          m(2, 0) * x + m(2, 1) * y + m(2, 2) * z + m(2, 3)};
}

CORBSLAM_LANES Corner Cross(const Corner& p, const Corner& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
CORBSLAM_LANES Corner Minus(const Corner& p, const Corner& q) {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}

CORBSLAM_LANES void SetSides(const std::array<Corner, 4>& corners, FaceLanes& face) {
  const Corner normal = Cross(Minus(corners[2], corners[0]), Minus(corners[3], corners[1]));
  const Floats plane = normal.x * corners[0].x + normal.y * corners[0].y + normal.z * corners[0].z;
  const Floats side = Select(plane < 0, All(-1), All(1));
  for (size_t k = 0; k < 4; ++k) {
    const Corner edge = Cross(corners[k], corners[(k + 1) % 4]);
    face.a[k] = edge.x * side;
    face.b[k] = edge.y * side;
    face.c[k] = edge.z * side;
  }
  // A face that is seen edge-on is nowhere.
  const Floats inverse = Select(Magnitude(plane) > 1e-12F, 1.0F / plane, All(0));
  face.near_a = normal.x * inverse;
  face.near_b = normal.y * inverse;
  face.near_c = normal.z * inverse;
}

// Sets the bounds of pixels that may be covered; left > right where there are none.
CORBSLAM_LANES void SetBounds(const std::array<Corner, 4>& corners, int width_px, int height_px,
                              FaceLanes& face) {
  constexpr float kFar = 1e6F;
  Floats left = All(kFar), right = All(-kFar), top = All(kFar), bottom = All(-kFar);
  Floats nearest = All(0);
  Floats least_z = corners[0].z, most_z = corners[0].z;
  for (const Corner& corner : corners) {
    const Floats inverse = 1.0F / Most(corner.z, All(kNearestDepth_m));
    left = Least(left, corner.x * inverse);
    right = Most(right, corner.x * inverse);
    top = Least(top, corner.y * inverse);
    bottom = Most(bottom, corner.y * inverse);
    nearest = Most(nearest, inverse);
    least_z = Least(least_z, corner.z);
    most_z = Most(most_z, corner.z);
  }
  const Floats width = All(static_cast<float>(width_px - 1));
  const Floats height = All(static_cast<float>(height_px - 1));
  // A face that reaches behind the camera may be anywhere, unless all of it is beyond one border.
  const Ints behind = least_z < kNearestDepth_m;
  Ints beyond = most_z < kNearestDepth_m;
  Ints all_left = Ints{} - 1, all_right = Ints{} - 1, all_above = Ints{} - 1,
       all_below = Ints{} - 1;
  for (const Corner& corner : corners) {
    all_left &= corner.x < -0.5F * corner.z;
    all_right &= corner.x > (width + 0.5F) * corner.z;
    all_above &= corner.y < -0.5F * corner.z;
    all_below &= corner.y > (height + 0.5F) * corner.z;
  }
  beyond |= all_left | all_right | all_above | all_below;
  left = Select(behind, All(0), Most(left, All(0)));
  right = Select(behind, width, Least(right, width));
  top = Select(behind, All(0), Most(top, All(0)));
  bottom = Select(behind, height, Least(bottom, height));
  // Samples lie within half a pixel of the centre.
  face.left = FloorToInts(left + 0.5F);
  face.right = Select(beyond, Ints{} - 1, FloorToInts(right + 0.5F));
  face.top = FloorToInts(top + 0.5F);
  face.bottom = FloorToInts(bottom + 0.5F);
  face.nearest = nearest;
}

// Takes away the part of a long row that is outside for certain.
CORBSLAM_LANES void NarrowRow(const FaceLanes& face, int lane, int y, int& left, int& right) {
  float from = static_cast<float>(left);
  float to = static_cast<float>(right);
  for (size_t k = 0; k < 4; ++k) {
    const float a = face.a[k][lane];
    const float b = face.b[k][lane];
    const float slack = 0.5F * (std::abs(a) + std::abs(b));
    const float start = b * static_cast<float>(y) + face.c[k][lane] + slack;
    if (a > 0) {
      from = std::max(from, -start / a - 1);
    } else if (a < 0) {
      to = std::min(to, -start / a + 1);
    } else if (start < 0) {
      to = from - 1;
    }
  }
  left = from > to ? right + 1 : static_cast<int>(from);
  right = from > to ? right : static_cast<int>(to);
}

// A linear function of a pixel's place.
struct Plane {
  float a, b, c;
  // Returns the function at the samples instead of the pixels' centres.
  CORBSLAM_LANES Plane At(const SampleOffset& offset) const {
    return {a, b, a * offset.right_px + (b * offset.down_px + c)};
  }
  CORBSLAM_LANES float StartOfRow(int y) const { return b * static_cast<float>(y) + c; }
};

CORBSLAM_LANES bool Any(const Ints& mask) {
  int32_t any = 0;
  for (int lane = 0; lane < kNumbers; ++lane) any |= mask[lane];
  return any != 0;
}

// Draws one sample of each pixel; lanes where it is seen are added to `seen`.
CORBSLAM_LANES void DrawSample(const FaceLanes& face, int lane, size_t sample, int32_t id,
                               VisibilityBuffer& buffer, Ints& seen) {
  constexpr int kLong = 4 * kNumbers;
  const SampleOffset offset = buffer.samples()[sample];
  std::array<Plane, 4> sides;
  for (size_t k = 0; k < 4; ++k) {
    sides[k] = Plane{face.a[k][lane], face.b[k][lane], face.c[k][lane]}.At(offset);
  }
  const Plane near = Plane{face.near_a[lane], face.near_b[lane], face.near_c[lane]}.At(offset);
  for (int y = face.top[lane]; y <= face.bottom[lane]; ++y) {
    int left = face.left[lane];
    int right = face.right[lane];
    if (right - left > kLong) NarrowRow(face, lane, y, left, right);
    if (left > right) continue;
    const std::array<float, 4> starts = {sides[0].StartOfRow(y), sides[1].StartOfRow(y),
                                         sides[2].StartOfRow(y), sides[3].StartOfRow(y)};
    const float near_start = near.StartOfRow(y);
    Eight<float>* nearness = buffer.NearnessRow(sample, y);
    Eight<int32_t>* faces = buffer.FaceRow(sample, y);
    for (int block = left / kNumbers; block <= right / kNumbers; ++block) {
      const Floats x = Ramp() + static_cast<float>(kNumbers * block);
      const Floats here = near.a * x + near_start;
      const Floats before = Load(nearness[block]);
      Ints covered = (here > before) & (here <= VisibilityBuffer::kMostNearness);
      for (size_t k = 0; k < 4; ++k) covered &= sides[k].a * x + starts[k] >= 0;
      Store(Select(covered, here, before), nearness[block]);
      Store(Select(covered, Ints{} + id, Load(faces[block])), faces[block]);
      seen |= covered;
    }
  }
}

// Returns whether a sample of the face was seen.
CORBSLAM_LANES bool DrawFace(const FaceLanes& face, int lane, int32_t id,
                             VisibilityBuffer& buffer) {
  const PixelRect rect = {face.left[lane], face.right[lane], face.top[lane], face.bottom[lane]};
  if (buffer.IsKnownHidden(rect, face.nearest[lane])) return false;
  Ints seen = {};
  for (size_t sample = 0; sample < buffer.samples().size(); ++sample) {
    DrawSample(face, lane, sample, id, buffer, seen);
  }
  if (!Any(seen)) return false;
  buffer.MarkChanged(rect);
  return true;
}

CORBSLAM_LANES void DrawGroups(const FaceMesh& mesh, const FaceCluster& cluster,
                               const PixelFromMesh& pixel_from_mesh, uint32_t placement,
                               VisibilityBuffer& buffer, std::vector<DrawnFace>& drawn) {
  for (uint32_t i = 0; i < cluster.group_count; ++i) {
    const FaceGroup& group = mesh.groups[cluster.first_group + i];
    const std::array<Corner, 4> corners = {
        Project(group, 0, pixel_from_mesh), Project(group, 1, pixel_from_mesh),
        Project(group, 2, pixel_from_mesh), Project(group, 3, pixel_from_mesh)};
    FaceLanes face;
    SetBounds(corners, buffer.width_px(), buffer.height_px(), face);
    SetSides(corners, face);
    for (int lane = 0; lane < static_cast<int>(group.count); ++lane) {
      if (face.left[lane] > face.right[lane]) continue;
      if (!DrawFace(face, lane, static_cast<int32_t>(drawn.size()), buffer)) continue;
      drawn.push_back({.nearness = {face.near_a[lane], face.near_b[lane], face.near_c[lane]},
                       .placement = placement,
                       .patch = group.patch.lanes[static_cast<size_t>(lane)]});
    }
  }
}

using DrawFunction = void (*)(const FaceMesh&, const FaceCluster&, const PixelFromMesh&, uint32_t,
                              VisibilityBuffer&, std::vector<DrawnFace>&);

struct Portable {
  static void Run(const FaceMesh& mesh, const FaceCluster& cluster, const PixelFromMesh& projection,
                  uint32_t placement, VisibilityBuffer& buffer, std::vector<DrawnFace>& drawn) {
    DrawGroups(mesh, cluster, projection, placement, buffer, drawn);
  }
};
#if defined(__x86_64__)
struct Avx2 {
  [[gnu::target("avx2")]] static void Run(const FaceMesh& mesh, const FaceCluster& cluster,
                                          const PixelFromMesh& projection, uint32_t placement,
                                          VisibilityBuffer& buffer, std::vector<DrawnFace>& drawn) {
    DrawGroups(mesh, cluster, projection, placement, buffer, drawn);
  }
};
#endif

DrawFunction ChooseDraw() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return &Avx2::Run;
#endif
  return &Portable::Run;
}

}  // namespace

std::optional<SeenBox> SeeBox(const Eigen::AlignedBox3f& box, const PixelFromMesh& pixel_from_mesh,
                              int width_px, int height_px) {
  Eigen::Matrix<float, 4, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners.col(i) << box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i)), 1.0F;
  }
  const Eigen::Matrix<float, 3, 8> seen = pixel_from_mesh * corners;
  const auto x = seen.row(0).array();
  const auto y = seen.row(1).array();
  const auto z = seen.row(2).array();
  const float width = static_cast<float>(width_px) - 0.5F;
  const float height = static_cast<float>(height_px) - 0.5F;
  if ((z < kNearestDepth_m).all() || (x < -0.5F * z).all() || (x > width * z).all() ||
      (y < -0.5F * z).all() || (y > height * z).all()) {
    return std::nullopt;
  }
  if ((z < kNearestDepth_m).any()) {
    return SeenBox{{0, width_px - 1, 0, height_px - 1}, VisibilityBuffer::kMostNearness};
  }
  const auto first = [](float least) { return std::max(0, static_cast<int>(least + 0.5F)); };
  const auto last = [](float most, int size) {
    return std::min(size - 1, static_cast<int>(most + 0.5F));
  };
  return SeenBox{{first(std::max(0.0F, (x / z).minCoeff())), last((x / z).maxCoeff(), width_px),
                  first(std::max(0.0F, (y / z).minCoeff())), last((y / z).maxCoeff(), height_px)},
                 1 / z.minCoeff()};
}

void DrawCluster(const FaceMesh& mesh, const FaceCluster& cluster,
                 const PixelFromMesh& pixel_from_mesh, uint32_t placement, VisibilityBuffer* buffer,
                 std::vector<DrawnFace>* drawn) {
  static const DrawFunction draw = ChooseDraw();
  draw(mesh, cluster, pixel_from_mesh, placement, *buffer, *drawn);
}

}  // namespace corbslam
