// What surface patterns are made of: functions of a place on a surface that know how large a pixel
// is there, so that what is finer than a pixel averages out instead of flickering.
//
// Sizes and places in metres; `pixel` is the pixel's extent along u and v at that place.
#ifndef CORBSLAM_SERVICES_SIMULATION_PATTERN_NOISE_H_
#define CORBSLAM_SERVICES_SIMULATION_PATTERN_NOISE_H_

#include "services/simulation/lanes.h"

namespace corbslam {

struct SurfacePlace {
  Floats u;
  Floats v;
  Floats pixel_u;
  Floats pixel_v;
  Uints seed;
};

// Returns thirty-two well mixed bits of a cell's indices and a seed.
CORBSLAM_LANES Uints HashCell(const Ints& i, const Ints& j, const Uints& seed) {
  Uints h = (Uints)i * 0x9E3779B1U;
  h ^= (h >> 15) + seed;
  h = (h + (Uints)j) * 0x85EBCA77U;
  h ^= h >> 13;
  h *= 0xC2B2AE3DU;
  return h ^ (h >> 16);
}

// Returns numbers from -1 to 1.
CORBSLAM_LANES Floats SignedUnit(const Uints& hash) {
  const Ints bits = (Ints)hash >> 8;
  return ToFloats(bits) * (1.0F / (1 << 23));
}
// Returns numbers from 0 to 1.
CORBSLAM_LANES Floats Unit(const Uints& hash) { return 0.5F * SignedUnit(hash) + 0.5F; }

// Returns how much of a feature of one cell's size is left when a pixel covers `cells` cells.
CORBSLAM_LANES Floats Visible(const Floats& cells_u, const Floats& cells_v) {
  return Clamp01(2.0F - 2.0F * cells_u) * Clamp01(2.0F - 2.0F * cells_v);
}

struct Lattice {
  Ints i, j;    // The cell whose centre is the nearest up and left.
  Floats s, t;  // Shares of the next cell's values.
  Floats visible;
};

// `edge` is the width of the transition between two cells in cells, 0 (sharp) to 1 (linear).
CORBSLAM_LANES Lattice LatticeAt(const SurfacePlace& at, float size_u, float size_v, float edge) {
  const Floats x = at.u * (1 / size_u) - 0.5F;
  const Floats y = at.v * (1 / size_v) - 0.5F;
  const Floats w = at.pixel_u * (1 / size_u);
  const Floats h = at.pixel_v * (1 / size_v);
  Lattice lattice;
  lattice.i = FloorToInts(x);
  lattice.j = FloorToInts(y);
  const Floats slope_u = 1.0F / Most(w, All(edge + 1e-3F));
  const Floats slope_v = 1.0F / Most(h, All(edge + 1e-3F));
  lattice.s = Clamp01((x - ToFloats(lattice.i) - 0.5F) * slope_u + 0.5F);
  lattice.t = Clamp01((y - ToFloats(lattice.j) - 0.5F) * slope_v + 0.5F);
  lattice.visible = Visible(w, h);
  return lattice;
}

// Returns a random value a cell, -1 to 1; cells are rectangles with sharp edges (edge 0) or melt
// into each other (edge 1).
CORBSLAM_LANES Floats CellNoise(const SurfacePlace& at, float size_u, float size_v, float edge,
                                uint32_t layer) {
  const Lattice l = LatticeAt(at, size_u, size_v, edge);
  const Uints seed = at.seed + layer * 0x632BE5ABU;
  const Floats a = SignedUnit(HashCell(l.i, l.j, seed));
  const Floats b = SignedUnit(HashCell(l.i + 1, l.j, seed));
  const Floats c = SignedUnit(HashCell(l.i, l.j + 1, seed));
  const Floats d = SignedUnit(HashCell(l.i + 1, l.j + 1, seed));
  return Mix(Mix(a, b, l.s), Mix(c, d, l.s), l.t) * l.visible;
}

// Returns the same place on axes turned by an angle whose cosine and sine are given, so that cells
// of several layers don't line up.
CORBSLAM_LANES SurfacePlace Turned(const SurfacePlace& at, float cosine, float sine) {
  SurfacePlace turned;
  turned.u = at.u * cosine + at.v * sine;
  turned.v = at.v * cosine - at.u * sine;
  turned.pixel_u = at.pixel_u * Magnitude(All(cosine)) + at.pixel_v * Magnitude(All(sine));
  turned.pixel_v = at.pixel_v * Magnitude(All(cosine)) + at.pixel_u * Magnitude(All(sine));
  turned.seed = at.seed;
  return turned;
}

// Lays layers of cell noise over each other, from `size` down by factors of about three, sharp and
// soft in turn; the result is about -1 to 1. It looks mottled, like stone, asphalt or plaster.
CORBSLAM_LANES Floats Mottle(const SurfacePlace& at, float size, uint32_t layer) {
  const SurfacePlace turned = Turned(at, 0.8F, 0.6F);
  const SurfacePlace other = Turned(at, 0.28F, -0.96F);
  return 0.36F * CellNoise(turned, size, size, 1.0F, layer) +
         0.30F * CellNoise(other, 0.31F * size, 0.27F * size, 0.4F, layer + 1) +
         0.28F * CellNoise(turned, 0.11F * size, 0.09F * size, 0.2F, layer + 2) +
         0.25F * CellNoise(other, 0.034F * size, 0.03F * size, 0.2F, layer + 3);
}

// Returns the share of the pixel that lies on bars of width `width` that repeat every `period` from
// 0 on: exact for a box of the pixel's size.
CORBSLAM_LANES Floats Bars(const Floats& x, const Floats& pixel, const Floats& period,
                           const Floats& width) {
  const Floats half = Most(pixel, All(1e-4F)) * 0.5F;
  const Floats a = (x - half) / period;
  const Floats b = (x + half) / period;
  const Floats share = width / period;
  const Floats whole_a = ToFloats(FloorToInts(a));
  const Floats whole_b = ToFloats(FloorToInts(b));
  const Floats covered_a = whole_a * share + Least(a - whole_a, share);
  const Floats covered_b = whole_b * share + Least(b - whole_b, share);
  return (covered_b - covered_a) / (b - a);
}

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_PATTERN_NOISE_H_
