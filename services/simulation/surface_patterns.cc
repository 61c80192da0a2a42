#include "services/simulation/surface_patterns.h"

#include <cstring>

#include "services/simulation/pattern_noise.h"

namespace corbslam {
namespace {

// Returns a number that the whole surface shares, 0 to 1.
CORBSLAM_LANES Floats OfSurface(const SurfacePlace& at, int32_t which) {
  return Unit(HashCell(Ints{} + which, Ints{} + 7919, at.seed));
}

CORBSLAM_LANES SurfacePlace Shifted(const SurfacePlace& at, const Floats& u, const Floats& v) {
  SurfacePlace shifted = at;
  shifted.u += u;
  shifted.v += v;
  return shifted;
}

CORBSLAM_LANES Floats Asphalt(const SurfacePlace& at) {
  // The road has patches where it was mended, cracks, grains.
  const SurfacePlace turned = Turned(at, 0.955F, 0.296F);
  const Floats mended = CellNoise(turned, 4.1F, 2.3F, 0.02F, 11);
  return 0.30F + 0.05F * mended + 0.13F * Mottle(at, 1.3F, 12) +
         0.12F * CellNoise(at, 0.05F, 0.035F, 0.2F, 17) +
         0.11F * CellNoise(turned, 0.017F, 0.017F, 0.2F, 18);
}

CORBSLAM_LANES Floats Pavement(const SurfacePlace& at) {
  const Floats joint = Most(Bars(at.u, at.pixel_u, All(0.5F), All(0.02F)),
                            Bars(at.v, at.pixel_v, All(0.5F), All(0.02F)));
  return 0.48F - 0.25F * joint + 0.07F * CellNoise(at, 0.5F, 0.5F, 0.0F, 21) +
         0.12F * Mottle(at, 0.9F, 22) + 0.09F * CellNoise(at, 0.03F, 0.03F, 0.2F, 26);
}

CORBSLAM_LANES Floats Grass(const SurfacePlace& at) {
  return 0.27F + 0.2F * Mottle(at, 1.1F, 31) + 0.2F * CellNoise(at, 0.05F, 0.12F, 0.2F, 36);
}

CORBSLAM_LANES Floats Plaster(const SurfacePlace& at) {
  const Floats base = 0.45F + 0.35F * OfSurface(at, 1);
  const Floats roughness = 0.05F + 0.12F * OfSurface(at, 2);
  return base + roughness * Mottle(at, 2.1F, 41);
}

CORBSLAM_LANES Floats Brick(const SurfacePlace& at) {
  const Ints row = FloorToInts(at.v * (1 / 0.083F));
  const Floats offset = ToFloats(row & 1) * 0.13F;
  const SurfacePlace bricks = Shifted(at, offset, All(0));
  const Floats mortar = Most(Bars(bricks.u, at.pixel_u, All(0.26F), All(0.014F)),
                             Bars(at.v, at.pixel_v, All(0.083F), All(0.014F)));
  const Floats base = 0.3F + 0.15F * OfSurface(at, 1);
  return base + 0.17F * mortar + 0.13F * CellNoise(bricks, 0.26F, 0.083F, 0.0F, 51) +
         0.12F * Mottle(at, 1.7F, 52);
}

// Draws a window: frame, crossbars, and behind the glass a curtain or what the glass mirrors.
CORBSLAM_LANES Floats Window(const SurfacePlace& at, const Floats& pitch) {
  const Ints column = FloorToInts(at.u / pitch);
  const Ints storey = FloorToInts(at.v * (1 / 3.0F));
  const Uints own = HashCell(column, storey, at.seed + 77U);
  SurfacePlace behind = at;
  behind.seed = own;
  const Floats curtain = 0.08F + 0.4F * Unit(own) * Unit(own * 0x2545F491U);
  const Floats glass = curtain + 0.12F * CellNoise(behind, 0.31F, 0.43F, 0.05F, 61) +
                       0.07F * CellNoise(behind, 0.11F, 0.5F, 0.1F, 62);
  const Floats bars = Bars(at.u, at.pixel_u, 0.5F * pitch, All(0.05F));
  return Mix(glass, All(0.75F), bars);
}

CORBSLAM_LANES Floats Facade(const SurfacePlace& at) {
  const Floats pitch = 1.9F + 1.3F * OfSurface(at, 3);
  const Floats width = 0.9F + 0.5F * OfSurface(at, 4);
  const Floats margin = 0.5F * (pitch - width);
  const Floats storey = All(3.0F);
  const Floats height = All(1.45F);
  const Floats pane = Bars(at.u - margin, at.pixel_u, pitch, width) *
                      Bars(at.v - 0.75F, at.pixel_v, storey, height);
  const Floats framed = Bars(at.u - margin + 0.09F, at.pixel_u, pitch, width + 0.18F) *
                        Bars(at.v - 0.66F, at.pixel_v, storey, height + 0.24F);
  const Floats ledge = Bars(at.v - 2.92F, at.pixel_v, storey, All(0.1F));
  const Floats is_brick = Select(OfSurface(at, 5) > 0.6F, All(1), All(0));
  const Floats wall = Mix(Plaster(at), Brick(at), is_brick);
  const Floats frame = 0.35F + 0.5F * OfSurface(at, 6);
  const Floats with_ledge = Mix(wall, wall * 0.7F + 0.05F, ledge);
  return Mix(Mix(with_ledge, frame, framed), Window(at, pitch), pane);
}

CORBSLAM_LANES Floats RoofTiles(const SurfacePlace& at) {
  const Floats lines = Bars(at.v, at.pixel_v, All(0.33F), All(0.05F));
  return 0.27F + 0.1F * OfSurface(at, 1) - 0.13F * lines +
         0.1F * CellNoise(at, 0.24F, 0.33F, 0.05F, 71) + 0.1F * Mottle(at, 2.3F, 72);
}

CORBSLAM_LANES Floats Door(const SurfacePlace& at) {
  const Floats panels = Bars(at.u - 0.12F, at.pixel_u, All(0.5F), All(0.3F)) *
                        Bars(at.v - 0.15F, at.pixel_v, All(0.7F), All(0.5F));
  const Floats base = 0.15F + 0.5F * OfSurface(at, 1);
  return base * (1.0F - 0.35F * panels) + 0.05F * Mottle(at, 0.6F, 81);
}

CORBSLAM_LANES Floats Wood(const SurfacePlace& at) {
  const Floats gap = Bars(at.u, at.pixel_u, All(0.12F), All(0.02F));
  const Floats base = 0.3F + 0.3F * OfSurface(at, 1);
  return base - 0.22F * gap + 0.1F * CellNoise(at, 0.12F, 30.0F, 0.0F, 91) +
         0.08F * CellNoise(at, 0.02F, 0.4F, 0.4F, 92) + 0.06F * Mottle(at, 0.8F, 93);
}

// Draws leaves in the sun and dark gaps between them.
CORBSLAM_LANES Floats Foliage(const SurfacePlace& at, float leaf) {
  const SurfacePlace turned = Turned(at, 0.6F, 0.8F);
  const Floats leaves = CellNoise(turned, leaf, 1.4F * leaf, 0.12F, 102);
  return 0.24F + 0.13F * CellNoise(at, 3.1F * leaf, 2.7F * leaf, 0.3F, 101) +
         0.24F * leaves * Magnitude(leaves) + 0.1F * leaves +
         0.12F * CellNoise(at, 0.45F * leaf, 0.4F * leaf, 0.2F, 103);
}

CORBSLAM_LANES Floats Bark(const SurfacePlace& at) {
  return 0.22F + 0.1F * CellNoise(at, 0.05F, 0.3F, 0.2F, 111) + 0.1F * Mottle(at, 0.4F, 112);
}

CORBSLAM_LANES Floats Metal(const SurfacePlace& at) {
  return 0.25F + 0.3F * OfSurface(at, 1) + 0.06F * Mottle(at, 0.5F, 121);
}

CORBSLAM_LANES Floats CarPaint(const SurfacePlace& at) {
  const Floats base = 0.06F + 0.7F * OfSurface(at, 1);
  const Floats seams = Bars(at.u, at.pixel_u, All(1.1F), All(0.012F));
  // The noise stands for what the paint mirrors.
  return base - 0.1F * seams + 0.08F * CellNoise(at, 0.9F, 0.35F, 0.5F, 131) +
         0.03F * CellNoise(at, 0.15F, 0.1F, 0.3F, 132);
}

CORBSLAM_LANES Floats Glass(const SurfacePlace& at) {
  return 0.12F + 0.12F * CellNoise(at, 0.7F, 0.4F, 0.3F, 141) +
         0.05F * CellNoise(at, 0.2F, 0.2F, 0.2F, 142);
}

CORBSLAM_LANES Floats Tyre(const SurfacePlace& at) {
  return 0.1F + 0.15F * CellNoise(at, 0.15F, 0.15F, 0.1F, 151);
}

CORBSLAM_LANES Floats RoadMarking(const SurfacePlace& at) {
  const Floats worn = 0.5F + 0.5F * Mottle(at, 0.6F, 161);
  return 0.6F + 0.25F * worn;
}

// Draws print: lines of words between margins.
CORBSLAM_LANES Floats Sign(const SurfacePlace& at) {
  const Floats lines = Bars(at.v - 0.04F, at.pixel_v, All(0.16F), All(0.08F));
  const Floats words = 0.5F + 0.5F * CellNoise(at, 0.13F, 0.16F, 0.0F, 171);
  const Floats letters = 0.6F + 0.4F * CellNoise(at, 0.022F, 0.05F, 0.0F, 172);
  const Floats field = CellNoise(at, 0.37F, 0.29F, 0.0F, 173);
  const Floats ground = 0.55F + 0.3F * OfSurface(at, 1) + 0.15F * field;
  return Mix(ground, All(0.1F), 0.8F * lines * words * letters);
}

CORBSLAM_LANES Floats Wallpaper(const SurfacePlace& at) {
  const Floats stripes = Bars(at.u, at.pixel_u, All(0.53F), All(0.02F));
  const Floats board = Bars(at.v - 2.68F, at.pixel_v, All(60), All(0.12F));
  return Mix(0.55F + 0.25F * OfSurface(at, 1) - 0.04F * stripes +
                 (0.04F + 0.08F * OfSurface(at, 2)) * Mottle(at, 1.1F, 181) +
                 0.06F * CellNoise(at, 0.09F, 0.13F, 0.1F, 186) +
                 0.05F * CellNoise(at, 0.021F, 0.017F, 0.2F, 187),
             All(0.2F), board);
}

CORBSLAM_LANES Floats FloorTiles(const SurfacePlace& at) {
  const Floats joint = Most(Bars(at.u, at.pixel_u, All(0.33F), All(0.01F)),
                            Bars(at.v, at.pixel_v, All(0.33F), All(0.01F)));
  return 0.42F - 0.2F * joint + 0.08F * CellNoise(at, 0.33F, 0.33F, 0.0F, 191) +
         0.13F * Mottle(at, 0.5F, 192);
}

CORBSLAM_LANES Floats Carpet(const SurfacePlace& at) {
  return 0.25F + 0.2F * OfSurface(at, 1) + 0.12F * CellNoise(at, 0.4F, 0.4F, 0.05F, 201) +
         0.1F * Mottle(at, 0.3F, 202) + 0.07F * CellNoise(at, 0.02F, 0.03F, 0.2F, 207);
}

CORBSLAM_LANES Floats Shelf(const SurfacePlace& at) {
  const Floats board = Bars(at.v, at.pixel_v, All(0.35F), All(0.03F));
  const Floats book = 0.38F + 0.33F * CellNoise(at, 0.037F, 0.35F, 0.02F, 211) +
                      0.12F * CellNoise(at, 0.037F, 0.07F, 0.05F, 212);
  return Mix(book, All(0.55F), board);
}

CORBSLAM_LANES Floats Ceiling(const SurfacePlace& at) {
  const Floats joint = Most(Bars(at.u, at.pixel_u, All(0.6F), All(0.02F)),
                            Bars(at.v, at.pixel_v, All(0.6F), All(0.02F)));
  return 0.75F - 0.25F * joint + 0.06F * Mottle(at, 0.3F, 221) +
         0.07F * CellNoise(at, 0.025F, 0.025F, 0.1F, 226);
}

// Draws clouds, which are soft at every scale.
CORBSLAM_LANES Floats Sky(const SurfacePlace& at) {
  return 0.86F + 0.1F * CellNoise(at, 900, 700, 1.0F, 231) +
         0.05F * CellNoise(Turned(at, 0.8F, 0.6F), 310, 270, 1.0F, 232) +
         0.02F * CellNoise(at, 100, 90, 1.0F, 233);
}

CORBSLAM_LANES Floats Pattern(Material material, const SurfacePlace& at) {
  switch (material) {
    case Material::kAsphalt:
      return Asphalt(at);
    case Material::kPavement:
      return Pavement(at);
    case Material::kGrass:
      return Grass(at);
    case Material::kPlaster:
      return Plaster(at);
    case Material::kBrick:
      return Brick(at);
    case Material::kFacade:
      return Facade(at);
    case Material::kRoofTiles:
      return RoofTiles(at);
    case Material::kDoor:
      return Door(at);
    case Material::kWood:
      return Wood(at);
    case Material::kHedge:
      return Foliage(at, 0.06F);
    case Material::kBark:
      return Bark(at);
    case Material::kLeaves:
      return Foliage(at, 0.075F);
    case Material::kMetal:
      return Metal(at);
    case Material::kCarPaint:
      return CarPaint(at);
    case Material::kGlass:
      return Glass(at);
    case Material::kTyre:
      return Tyre(at);
    case Material::kRoadMarking:
      return RoadMarking(at);
    case Material::kSign:
      return Sign(at);
    case Material::kWallpaper:
      return Wallpaper(at);
    case Material::kFloorTiles:
      return FloorTiles(at);
    case Material::kCarpet:
      return Carpet(at);
    case Material::kShelf:
      return Shelf(at);
    case Material::kCeiling:
      return Ceiling(at);
    case Material::kSky:
      return Sky(at);
  }
  return All(0.5F);
}

template <typename T, size_t N>
CORBSLAM_LANES void Load(const std::array<T, N>& from, int first, auto& to) {
  static_assert(sizeof(to) == kNumbers * sizeof(T));
  std::memcpy(&to, from.data() + first, sizeof(to));
}

CORBSLAM_LANES SurfacePlace PlaceOf(const SurfacePacket& surface, int first) {
  SurfacePlace at;
  Load(surface.u_m, first, at.u);
  Load(surface.v_m, first, at.v);
  Load(surface.pixel_u_m, first, at.pixel_u);
  Load(surface.pixel_v_m, first, at.pixel_v);
  Load(surface.seed, first, at.seed);
  return at;
}

// Each material among eight lanes is drawn for all of them and kept where it is theirs.
CORBSLAM_LANES void Compute(const SurfacePacket& surface, std::array<float, kLanes>& reflectance) {
  std::array<bool, kLanes> open = surface.hit;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    if (!open[lane]) continue;
    const size_t first = lane - lane % kNumbers;
    const SurfacePlace at = PlaceOf(surface, static_cast<int>(first));
    const Floats values = Clamp01(Pattern(surface.material[lane], at));
    for (size_t other = lane; other < first + kNumbers; ++other) {
      if (!open[other] || surface.material[other] != surface.material[lane]) continue;
      reflectance[other] = values[other - first];
      open[other] = false;
    }
  }
}

struct Portable {
  static void Run(const SurfacePacket& surface, std::array<float, kLanes>& reflectance) {
    Compute(surface, reflectance);
  }
};
#if defined(__x86_64__)
struct Avx2 {
  [[gnu::target("avx2")]] static void Run(const SurfacePacket& surface,
                                          std::array<float, kLanes>& reflectance) {
    Compute(surface, reflectance);
  }
};
#endif

using ComputeFunction = void (*)(const SurfacePacket&, std::array<float, kLanes>&);

ComputeFunction ChooseCompute() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return &Avx2::Run;
#endif
  return &Portable::Run;
}

}  // namespace

void ComputeReflectance(const SurfacePacket& surface, std::array<float, kLanes>& reflectance) {
  static const ComputeFunction compute = ChooseCompute();
  compute(surface, reflectance);
}

}  // namespace corbslam
