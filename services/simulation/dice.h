// Makes random numbers that are the same with every compiler and library, by SplitMix64 (Steele,
// Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014).
#ifndef CORBSLAM_SERVICES_SIMULATION_DICE_H_
#define CORBSLAM_SERVICES_SIMULATION_DICE_H_

#include <cstdint>

namespace corbslam {

// Dice are cheap to make: each thing that is built has its own. Not thread-safe. At most one
// argument of a call may draw: compilers evaluate the others before or after it as they like (gcc
// for x86-64 from the last to the first, for arm64 the other way), and another order makes another
// world.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(seed) {}

  // Returns the dice of one thing among many: `purpose` keeps kinds apart, `a` and `b` say which or
  // where.
  static Dice For(uint64_t seed, uint64_t purpose, int64_t a, int64_t b = 0) {
    Dice dice(seed);
    for (const uint64_t part : {purpose, static_cast<uint64_t>(a), static_cast<uint64_t>(b)}) {
      dice.state_ = dice.Next() ^ (part * 0x9E6C63D0876A9A47ULL);
    }
    return dice;
  }

  uint64_t Next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    uint64_t bits = state_;
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9ULL;
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBULL;
    return bits ^ (bits >> 31);
  }
  uint32_t Seed() { return static_cast<uint32_t>(Next() >> 32); }
  // Returns a number from `low` to `high`, `high` excluded.
  double Uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(Next() >> 11) * 0x1p-53);
  }
  float Uniformf(double low, double high) { return static_cast<float>(Uniform(low, high)); }
  // Returns a number from `low` to `high`, both included.
  int Integer(int low, int high) {
    return low + static_cast<int>(Next() % static_cast<uint64_t>(high - low + 1));
  }
  bool Chance(double share) { return Uniform(0, 1) < share; }

 private:
  uint64_t state_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_DICE_H_
