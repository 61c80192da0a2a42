#include "services/simulation/worlds/plants.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "services/simulation/dice.h"
#include "services/simulation/worlds/mesh_shapes.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

Vector3f RandomDirection(Dice* dice) {
  const float up = dice->Uniformf(-1, 1);
  const float angle = dice->Uniformf(0, 2 * std::numbers::pi);
  const float flat = std::sqrt(std::max(0.0F, 1 - up * up));
  return {flat * std::cos(angle), up, flat * std::sin(angle)};
}

// Adds a patch of leaves that faces any way.
void AddClump(const Vector3f& centre, float size, float tone, Dice* dice, Mesh* mesh) {
  const Vector3f normal = RandomDirection(dice);
  const Vector3f u = normal.unitOrthogonal();
  const Vector3f v = normal.cross(u);
  const float turn = dice->Uniformf(0, 2 * std::numbers::pi);
  const Vector3f along = std::cos(turn) * u + std::sin(turn) * v;
  const Vector3f across = normal.cross(along);
  // The clump is a kite: no two sides are the same, so that no row of clumps looks like tiles.
  const float half = size / 2;
  const Finish leaves = {Material::kLeaves, dice->Seed(), tone};
  const float right = dice->Uniformf(0.5, 1.0);
  const float up = dice->Uniformf(0.7, 1.3);
  const float left = dice->Uniformf(0.5, 1.0);
  const float down = dice->Uniformf(0.7, 1.2);
  AddQuad(centre - half * down * along, centre - half * left * across, centre + half * up * along,
          centre + half * right * across, leaves, mesh);
}

// Clumps near the surface of an ellipsoid are brighter than those within, where it is dark.
void AddCrown(const Vector3f& centre, const Vector3f& radii, int clumps, float size, Dice* dice,
              Mesh* mesh) {
  for (int i = 0; i < clumps; ++i) {
    const float depth = std::cbrt(dice->Uniformf(0.08, 1.15));
    const Vector3f offset = depth * RandomDirection(dice);
    const float lit = 0.35F + 0.5F * depth * depth - 0.15F * offset.y();
    const float tone = lit * dice->Uniformf(0.75, 1.25);
    AddClump(centre + radii.cwiseProduct(offset), size * dice->Uniformf(0.65, 1.35), tone, dice,
             mesh);
  }
}

void AddBroadleaf(const TreeShape& shape, Dice* dice, Mesh* mesh) {
  const Finish bark = {Material::kBark, dice->Seed(), 0.9F};
  const float fork_z = dice->Uniformf(-0.15, 0.15);
  const Vector3f fork(dice->Uniformf(-0.15, 0.15), -shape.trunk, fork_z);
  AddTube({0, 0.4F, 0}, fork, 1.25F * shape.trunk_radius, shape.trunk_radius, 7, bark, mesh);
  const float crown_height = shape.height - shape.trunk;
  for (int i = 0; i < shape.branches; ++i) {
    const float angle = static_cast<float>(2 * std::numbers::pi) *
                        (static_cast<float>(i) + dice->Uniformf(-0.3, 0.3)) /
                        static_cast<float>(shape.branches);
    const float out = shape.crown_radius * dice->Uniformf(0.35, 0.75);
    const float up = crown_height * dice->Uniformf(0.3, 0.8);
    const Vector3f tip = fork + Vector3f(out * std::cos(angle), -up, out * std::sin(angle));
    const Vector3f bend = fork + 0.5F * (tip - fork) + Vector3f(0, 0.1F * up, 0);
    AddTube(fork, bend, 0.6F * shape.trunk_radius, 0.4F * shape.trunk_radius, 5, bark, mesh);
    AddTube(bend, tip, 0.4F * shape.trunk_radius, 0.15F * shape.trunk_radius, 4, bark, mesh);
    const float radius = shape.crown_radius * dice->Uniformf(0.36, 0.6);
    AddCrown(tip, {radius, 0.8F * radius, radius}, shape.clumps / (shape.branches + 1), shape.clump,
             dice, mesh);
  }
  const Vector3f top = fork - Vector3f(0, 0.62F * crown_height, 0);
  AddCrown(top, {0.6F * shape.crown_radius, 0.36F * crown_height, 0.6F * shape.crown_radius},
           shape.clumps / (shape.branches + 1), shape.clump, dice, mesh);
}

void AddConifer(const TreeShape& shape, Dice* dice, Mesh* mesh) {
  const Finish bark = {Material::kBark, dice->Seed(), 0.7F};
  AddTube({0, 0.4F, 0}, {0, -0.95F * shape.height, 0}, shape.trunk_radius, 0.03F, 6, bark, mesh);
  for (int i = 0; i < shape.clumps; ++i) {
    // Clumps are denser below, where the cone is wide; there are layers of boughs with gaps
    // between.
    const float share = 1 - std::sqrt(dice->Uniformf(0, 1));
    const float up = shape.trunk + share * (shape.height - shape.trunk);
    const float layer = 0.75F + 0.25F * std::cos(up * 7);
    const float reach = shape.crown_radius * (1.02F - share) * layer;
    const float angle = dice->Uniformf(0, 2 * std::numbers::pi);
    const float out = reach * std::sqrt(dice->Uniformf(0.15, 1));
    const float tone = (0.25F + 0.4F * out / (reach + 0.01F)) * dice->Uniformf(0.8, 1.2);
    AddClump({out * std::cos(angle), -up + 0.3F * out, out * std::sin(angle)},
             shape.clump * dice->Uniformf(0.6, 1.3), tone, dice, mesh);
  }
}

}  // namespace

Mesh BuildTree(const TreeShape& shape, uint64_t seed) {
  Mesh mesh;
  Dice dice(seed);
  if (shape.conifer) {
    AddConifer(shape, &dice, &mesh);
  } else {
    AddBroadleaf(shape, &dice, &mesh);
  }
  return mesh;
}

Mesh BuildBush(float radius, int clumps, uint64_t seed) {
  Mesh mesh;
  Dice dice(seed);
  AddCrown({0, -0.8F * radius, 0}, {radius, 0.9F * radius, radius}, clumps, 0.2F * radius, &dice,
           &mesh);
  return mesh;
}

Mesh BuildHedge(float length, float height, float thickness, uint64_t seed) {
  Mesh mesh;
  Dice dice(seed);
  const float half = thickness / 2;
  const float core = 0.08F;  // Leaves stand out of the dark core.
  AddBox({core, -height + core, -half + core}, {length - core, 0.5F, half - core},
         {Material::kHedge, dice.Seed(), 0.6F}, &mesh);
  const int clumps = static_cast<int>(length * (2 * height + thickness) * 9);
  for (int i = 0; i < clumps; ++i) {
    const float x = dice.Uniformf(0, length);
    const float way = dice.Uniformf(-height, height + thickness);  // It goes up, over and down.
    const bool top = way > height;
    const float y = top ? -height : -std::abs(way);
    const float z = top ? way - height - half : (way < 0 ? -half : half);
    const float tone = dice.Uniformf(0.5, 1.0) + (top ? 0.2F : 0.0F);
    AddClump({x, y, z}, dice.Uniformf(0.14, 0.3), tone, &dice, &mesh);
  }
  return mesh;
}

TreePrototypes BuildTreePrototypes(uint64_t seed) {
  TreePrototypes trees;
  Dice dice(seed);
  for (int i = 0; i < 5; ++i) {
    TreeShape shape;
    shape.height = dice.Uniformf(6.8, 9.5);
    shape.trunk = dice.Uniformf(2.5, 3.2);
    shape.crown_radius = dice.Uniformf(2.1, 3.0);
    shape.trunk_radius = dice.Uniformf(0.13, 0.24);
    shape.branches = dice.Integer(6, 10);
    shape.clumps = dice.Integer(1300, 2000);
    shape.clump = dice.Uniformf(0.2, 0.3);
    trees.street.push_back(BuildTree(shape, dice.Next()));
  }
  for (int i = 0; i < 6; ++i) {
    TreeShape shape;
    shape.conifer = i >= 4;
    shape.height = shape.conifer ? dice.Uniformf(7, 13) : dice.Uniformf(4.5, 11);
    shape.trunk = shape.conifer ? 0.3F : dice.Uniformf(0.9, 2.2);
    shape.crown_radius = shape.conifer ? dice.Uniformf(1.2, 2.4) : dice.Uniformf(1.8, 3.4);
    shape.trunk_radius = dice.Uniformf(0.1, 0.25);
    shape.clumps = dice.Integer(1300, 2200);
    shape.clump = dice.Uniformf(0.22, 0.34);
    trees.garden.push_back(BuildTree(shape, dice.Next()));
  }
  for (int i = 0; i < 4; ++i) {
    const uint64_t own = dice.Next();
    const int clumps = dice.Integer(450, 700);
    trees.bushes.push_back(BuildBush(dice.Uniformf(0.6, 1.2), clumps, own));
  }
  return trees;
}

}  // namespace corbslam
