#include "services/simulation/worlds/cars.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "services/simulation/dice.h"
#include "services/simulation/worlds/mesh_shapes.h"

namespace corbslam {
namespace {

using Eigen::Vector3f;

// The side view has heights above the ground, and z from the tail (negative) to the nose.
struct CarShape {
  float length;
  float width;
  float sill;    // Lower edge of the body.
  float bonnet;  // Height of the nose's upper edge.
  float belt;    // Lower edge of the windows.
  float roof;
  float boot;        // Height of the tail's upper edge.
  float windscreen;  // z of its foot.
  float roof_front;
  float roof_back;
  float rear_window;  // z of its foot.
};

struct Paints {
  Finish body;
  Finish glass;
  Finish black;
  Finish lamp;
  Finish plate;
};

// Adds a stretch of the body between two heights' profiles, seen from both sides and above.
void AddStretch(float z0, float y0, float z1, float y1, float half, float sill, const Paints& paint,
                Mesh* mesh) {
  AddQuad({-half, -y0, z0}, {half, -y0, z0}, {half, -y1, z1}, {-half, -y1, z1}, paint.body, mesh);
  for (const float x : {-half, half}) {
    AddQuad({x, -y0, z0}, {x, -y1, z1}, {x, -sill, z1}, {x, -sill, z0}, paint.body, mesh);
    mesh->patches.back().u_offset_m += x < 0 ? 40.0F : 80.0F;
  }
}

// The cabin's half width at the roof is less than at the belt.
void AddCabin(const CarShape& car, const Paints& paint, Mesh* mesh) {
  // There is no ledge at the belt: in the sun it would be a bright line thinner than a pixel, which
  // comes and goes along its length.
  const float low = car.width / 2;
  const float high = car.width / 2 - 0.2F;
  const Vector3f screen_low(low, -car.belt, car.windscreen);
  const Vector3f screen_high(high, -car.roof, car.roof_front);
  const Vector3f rear_high(high, -car.roof, car.roof_back);
  const Vector3f rear_low(low, -car.belt, car.rear_window);
  const auto left = [](const Vector3f& p) { return Vector3f(-p.x(), p.y(), p.z()); };
  AddQuad(left(screen_high), screen_high, screen_low, left(screen_low), paint.glass, mesh);
  AddQuad(left(rear_high), rear_high, screen_high, left(screen_high), paint.body, mesh);
  AddQuad(rear_high, left(rear_high), left(rear_low), rear_low, paint.glass, mesh);
  for (const float side : {-1.0F, 1.0F}) {
    const auto at = [&](const Vector3f& p) { return Vector3f(side * p.x(), p.y(), p.z()); };
    AddQuad(at(screen_low), at(screen_high), at(rear_high), at(rear_low), paint.body, mesh);
    // The painted side has two panes.
    const auto within = [&](float along, float up) -> Vector3f {
      const Vector3f below = screen_low + along * (rear_low - screen_low);
      const Vector3f above = screen_high + along * (rear_high - screen_high);
      return at(below + up * (above - below) + Vector3f(0.012F, 0, 0));
    };
    for (const auto& [from, to] : {std::pair(0.06F, 0.48F), std::pair(0.53F, 0.93F)}) {
      AddQuad(within(from, 0.88F), within(to, 0.88F), within(to, 0.1F), within(from, 0.1F),
              paint.glass, mesh);
    }
  }
}

void AddWheels(const CarShape& car, const Paints& paint, Mesh* mesh) {
  const float radius = 0.32F;
  for (const float z : {-0.31F * car.length, 0.31F * car.length}) {
    for (const float side : {-1.0F, 1.0F}) {
      const float x = side * (car.width / 2 + 0.005F);
      const Vector3f out(side, 0, 0);
      AddDisc({x, -radius - 0.03F, z}, out, radius + 0.06F, {Material::kTyre, 1, 0.4F}, mesh);
      AddDisc({x + side * 0.01F, -radius, z}, out, radius, {Material::kTyre, 2, 1}, mesh);
      AddDisc({x + side * 0.02F, -radius, z}, out, 0.6F * radius, {Material::kMetal, 3, 1.3F},
              mesh);
      for (int spoke = 0; spoke < 5; ++spoke) {
        const float angle = 1.2566F * static_cast<float>(spoke);
        const float hole = 0.38F * radius;
        AddDisc({x + side * 0.025F, -radius + hole * std::cos(angle), z + hole * std::sin(angle)},
                out, 0.12F * radius, paint.black, mesh);
      }
      AddQuad({x, 0, z - 0.12F}, {x - side * 0.25F, 0, z - 0.12F},
              {x - side * 0.25F, -0.3F, z - 0.2F}, {x, -0.3F, z - 0.2F}, paint.black, mesh);
    }
  }
}

// The bumper slopes out from the body: a flat top would be a ledge as well.
void AddBumper(float half, float z, float way, const Paints& paint, Mesh* mesh) {
  const float out = z + way * 0.09F;
  const auto across = [&](float top, float top_z, float low, float low_z) {
    AddQuad({-half, top, top_z}, {half, top, top_z}, {half, low, low_z}, {-half, low, low_z},
            paint.body, mesh);
    mesh->patches.back().u_offset_m += 120;
  };
  across(-0.62F, z, -0.5F, out);
  across(-0.5F, out, -0.3F, out);
  across(-0.3F, out, -0.26F, z);
  for (const float x : {-half, half}) {
    AddQuad({x, -0.62F, z}, {x, -0.5F, out}, {x, -0.3F, out}, {x, -0.26F, z}, paint.body, mesh);
  }
}

void AddEnd(const CarShape& car, float z, float top, bool nose, const Paints& paint, Mesh* mesh) {
  const float half = car.width / 2;
  const float way = nose ? 1.0F : -1.0F;
  const float out = z + way * 0.015F;
  mesh->patches.push_back(Rectangle({-half, -top, z}, {car.width, 0, 0}, {0, top - car.sill, 0},
                                    paint.body.material, paint.body.seed, paint.body.tone));
  AddBumper(half, z, way, paint, mesh);
  const auto plate = [&](float x, float y, float width, float height, const Finish& finish,
                         float layer) {
    mesh->patches.push_back(Rectangle({x - width / 2, y, out + way * layer}, {width, 0, 0},
                                      {0, height, 0}, finish.material, finish.seed, finish.tone));
  };
  for (const float x : {-half + 0.22F, half - 0.22F}) {
    plate(x, -top + 0.06F, 0.38F, 0.18F, paint.lamp, 0);
    plate(x, -top + 0.1F, 0.14F, 0.09F, paint.black, 0.01F);
  }
  plate(0, -0.47F, 0.52F, 0.12F, paint.plate, 0.09F);
  if (nose) plate(0, -top + 0.1F, 0.8F, 0.14F, paint.black, 0);
}

Mesh BuildCar(const CarShape& car, uint64_t seed) {
  Mesh mesh;
  Dice dice(seed);
  const Paints paint = {.body = {Material::kCarPaint, dice.Seed(), 1},
                        .glass = {Material::kGlass, dice.Seed(), 0.7F},
                        .black = {Material::kTyre, dice.Seed(), 0.5F},
                        .lamp = {Material::kGlass, dice.Seed(), 3.5F},
                        .plate = {Material::kSign, dice.Seed(), 1.3F}};
  const float half = car.width / 2;
  const float tail = -car.length / 2;
  const float nose = car.length / 2;
  AddStretch(car.windscreen, car.belt, nose, car.bonnet, half, car.sill, paint, &mesh);
  AddStretch(car.rear_window, car.belt, car.windscreen, car.belt, half, car.sill, paint, &mesh);
  AddStretch(tail, car.boot, car.rear_window, car.belt, half, car.sill, paint, &mesh);
  AddCabin(car, paint, &mesh);
  AddEnd(car, nose, car.bonnet, true, paint, &mesh);
  AddEnd(car, tail, car.boot, false, paint, &mesh);
  AddWheels(car, paint, &mesh);
  // What is under the car lies in its shade: part of the car, as the sun is high for its belly.
  mesh.patches.push_back(Rectangle({-half + 0.05F, -0.02F, tail + 0.1F}, {car.width - 0.1F, 0, 0},
                                   {0, 0, car.length - 0.2F}, Material::kAsphalt, 1, 0.2F));
  for (const float side : {-1.0F, 1.0F}) {
    const float from = side > 0 ? half : -half - 0.18F;
    AddBox({from, -car.belt - 0.12F, car.windscreen - 0.35F},
           {from + 0.18F, -car.belt + 0.03F, car.windscreen - 0.25F}, paint.body, &mesh, true);
    for (const float z : {car.windscreen - 0.9F, car.windscreen - 1.9F}) {
      const float x = side * (half + 0.01F);
      mesh.patches.push_back(Rectangle({x, -car.belt + 0.08F, z}, {0, 0, 0.18F}, {0, 0.04F, 0},
                                       Material::kTyre, paint.black.seed, 0.8F));
      mesh.patches.push_back(Rectangle({x, -car.belt, z + 0.5F}, {0, 0, 0.015F},
                                       {0, car.belt - car.sill, 0}, Material::kTyre,
                                       paint.black.seed, 0.5F));
    }
  }
  return mesh;
}

}  // namespace

std::vector<CarPrototype> BuildCarPrototypes(uint64_t seed) {
  static constexpr CarShape kShapes[] = {
      // The columns are: length width sill bonnet belt roof boot screen front back rear.
      {4.05F, 1.74F, 0.26F, 0.80F, 0.95F, 1.45F, 0.92F, 0.95F, 0.25F, -1.45F, -1.95F},
      {4.60F, 1.78F, 0.24F, 0.78F, 0.94F, 1.42F, 0.98F, 0.95F, 0.20F, -0.95F, -1.60F},
      {4.65F, 1.78F, 0.25F, 0.80F, 0.96F, 1.46F, 0.93F, 1.00F, 0.30F, -1.95F, -2.25F},
      {4.90F, 1.90F, 0.30F, 1.05F, 1.20F, 1.95F, 1.15F, 1.70F, 1.10F, -2.30F, -2.42F},
      {4.45F, 1.84F, 0.38F, 1.02F, 1.15F, 1.75F, 1.10F, 0.95F, 0.40F, -1.90F, -2.15F},
      {3.55F, 1.62F, 0.25F, 0.84F, 0.98F, 1.48F, 0.95F, 1.05F, 0.45F, -1.35F, -1.70F},
  };
  std::vector<CarPrototype> cars;
  Dice dice(seed);
  for (const CarShape& shape : kShapes) {
    cars.push_back({BuildCar(shape, dice.Next()), shape.length, shape.width});
  }
  return cars;
}

}  // namespace corbslam
