// Turns the fields of the ground into patches.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "services/simulation/worlds/mesh_shapes.h"
#include "services/simulation/worlds/street_ground.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

// Four corners this near to a plane count as flat.
constexpr float kFlatM = 0.002F;
constexpr float kSamePlaceM = 1e-4F;

// Lays the texture along the street's heading, the same for all the ground of that heading.
void AlignTexture(double angle_rad, Patch* patch) {
  const auto cosine = static_cast<float>(std::cos(angle_rad));
  const auto sine = static_cast<float>(std::sin(angle_rad));
  patch->u_axis = Vector3f(cosine, 0, sine);
  patch->v_axis = Vector3f(-sine, 0, cosine);
  patch->u_offset_m = 0;
  patch->v_offset_m = 0;
}

// Returns the part of a polygon where the distance is at least `limit_m`, or at most.
template <typename Corner>
std::vector<Corner> Clip(const std::vector<Corner>& polygon, double limit_m, bool at_least) {
  const auto limit = static_cast<float>(limit_m);
  const auto inside = [&](const Corner& corner) {
    return at_least ? corner.middle_m >= limit : corner.middle_m <= limit;
  };
  std::vector<Corner> kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Corner& from = polygon[i];
    const Corner& to = polygon[(i + 1) % polygon.size()];
    if (inside(from)) kept.push_back(from);
    if (inside(from) == inside(to)) continue;
    const float share = (limit - from.middle_m) / (to.middle_m - from.middle_m);
    kept.push_back({(1 - share) * from.at + share * to.at, limit});
  }
  return kept;
}

}  // namespace

StreetGround::Corner StreetGround::CornerAt(int fine_x, int fine_z) const {
  const Eigen::Vector2d at = origin_ + kFineM * Eigen::Vector2d(fine_x, fine_z);
  const size_t row = static_cast<size_t>(kFine * cells_x_) + 1;
  return {Eigen::Vector3d(at.x(), RoadY(at), at.y()).cast<float>(),
          middle_m_[static_cast<size_t>(fine_z) * row + static_cast<size_t>(fine_x)]};
}

void StreetGround::AddLevel(const std::vector<Corner>& polygon, Material material, const Soil& soil,
                            float raised_m, Mesh* mesh) {
  if (polygon.size() < 3) return;
  std::vector<Vector3f> corners;
  for (const Corner& corner : polygon) {
    const Vector3f at = corner.at - Vector3f(0, raised_m, 0);
    if (corners.empty() || (at - corners.back()).norm() > kSamePlaceM) corners.push_back(at);
  }
  const size_t first = mesh->patches.size();
  AddPolygon(corners, {material, static_cast<uint32_t>(soil.seed), 1}, mesh);
  const double angle = soil.heading * std::numbers::pi / 2 / kHeadings;
  for (size_t i = first; i < mesh->patches.size(); ++i) AlignTexture(angle, &mesh->patches[i]);
}

void StreetGround::AddKerb(const std::vector<Corner>& polygon, const Soil& soil, Mesh* mesh) {
  const Vector3f up(0, -static_cast<float>(StreetProfile::kKerbHeight), 0);
  const auto limit = static_cast<float>(StreetProfile::kKerb);
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Corner& from = polygon[i];
    const Corner& to = polygon[(i + 1) % polygon.size()];
    if (from.middle_m != limit || to.middle_m != limit) continue;
    if ((to.at - from.at).norm() < 1e-3F) continue;
    AddQuad(from.at + up, to.at + up, to.at, from.at,
            {Material::kPavement, static_cast<uint32_t>(soil.seed) + 7, 0.8F}, mesh);
  }
}

void StreetGround::AddTriangle(const std::vector<Corner>& triangle, const Soil& soil, Mesh* mesh) {
  using Profile = StreetProfile;
  const auto raised = static_cast<float>(Profile::kKerbHeight);
  const double stone = Profile::kKerb + Profile::kKerbStone;
  const auto beyond_kerb = Clip(triangle, Profile::kKerb, true);
  const auto beyond_stone = Clip(beyond_kerb, stone, true);
  AddLevel(Clip(triangle, Profile::kKerb, false), Material::kAsphalt, soil, 0, mesh);
  AddKerb(beyond_kerb, soil, mesh);
  const size_t kerb_stones = mesh->patches.size();
  AddLevel(Clip(beyond_kerb, stone, false), Material::kPavement, soil, raised, mesh);
  for (size_t i = kerb_stones; i < mesh->patches.size(); ++i) mesh->patches[i].tone = 1.3F;
  AddLevel(Clip(beyond_stone, Profile::kPavement, false), Material::kPavement, soil, raised, mesh);
  AddLevel(Clip(beyond_stone, Profile::kPavement, true), Material::kGrass, soil, raised, mesh);
}

void StreetGround::AddCell(int cell_x, int cell_z, uint64_t seed, Mesh* mesh) const {
  const int x = kFine * cell_x;
  const int z = kFine * cell_z;
  float least = static_cast<float>(kFarM);
  float most = 0;
  for (int dz = 0; dz <= kFine; ++dz) {
    for (int dx = 0; dx <= kFine; ++dx) {
      const Corner corner = CornerAt(x + dx, z + dz);
      if (!std::isfinite(
              height_[static_cast<size_t>((z + dz) / kFine) * (static_cast<size_t>(cells_x_) + 1) +
                      static_cast<size_t>((x + dx) / kFine)])) {
        return;
      }
      least = std::min(least, corner.middle_m);
      most = std::max(most, corner.middle_m);
    }
  }
  const size_t row = static_cast<size_t>(kFine * cells_x_) + 1;
  const Soil soil = {seed, heading_[static_cast<size_t>(z + 1) * row + static_cast<size_t>(x + 1)]};
  const bool whole = most <= StreetProfile::kKerb || least >= StreetProfile::kPavement;
  const int step = whole ? kFine : 1;
  for (int dz = 0; dz < kFine; dz += step) {
    for (int dx = 0; dx < kFine; dx += step) {
      const Corner near_left = CornerAt(x + dx, z + dz);
      const Corner near_right = CornerAt(x + dx + step, z + dz);
      const Corner far_right = CornerAt(x + dx + step, z + dz + step);
      const Corner far_left = CornerAt(x + dx, z + dz + step);
      const float bend = near_left.at.y() + far_right.at.y() - near_right.at.y() - far_left.at.y();
      if (whole && std::abs(bend) < kFlatM) {
        AddTriangle({near_left, near_right, far_right, far_left}, soil, mesh);
      } else {
        AddTriangle({near_left, near_right, far_right}, soil, mesh);
        AddTriangle({near_left, far_right, far_left}, soil, mesh);
      }
    }
  }
}

void StreetGround::AddTo(uint64_t seed, SceneChunks* chunks) const {
  for (int z = 0; z < cells_z_; ++z) {
    for (int x = 0; x < cells_x_; ++x) {
      AddCell(x, z, seed, chunks->At(origin_ + kCellM * Eigen::Vector2d(x + 0.5, z + 0.5)));
    }
  }
}

}  // namespace corbslam
