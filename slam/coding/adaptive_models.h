// Models of numbers that learn as they go, from bits that were coded before (binary_coder.h). A
// model's Code(coder, value) writes the value, or reads and returns it.
#ifndef CORBSLAM_SLAM_CODING_ADAPTIVE_MODELS_H_
#define CORBSLAM_SLAM_CODING_ADAPTIVE_MODELS_H_

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/coding/binary_coder.h"

namespace corbslam {

// Estimates a probability as the mean of two estimates: one that is quick, one that is exact.
class AdaptiveBit {
 public:
  template <typename Coder>
  bool Code(Coder& coder, bool bit) {
    bit = coder.Bit((uint32_t{quick_} + slow_) / 2, bit);
    quick_ = Toward(quick_, bit, 4);
    slow_ = Toward(slow_, bit, 7);
    return bit;
  }

 private:
  // Keeps the estimate within 15 to 65520, or within 127 to 65408.
  static uint16_t Toward(uint16_t estimate, bool bit, int shift) {
    return static_cast<uint16_t>(bit ? estimate + ((65535 - estimate) >> shift)
                                     : estimate - (estimate >> shift));
  }

  uint16_t quick_ = kEvenChance;
  uint16_t slow_ = kEvenChance;
};

// Codes numbers of a fixed count of bits, of which the first `kLearned` are learned together and
// the others taken as even.
template <int kLearned>
class BitsModel {
 public:
  template <typename Coder>
  uint32_t Code(Coder& coder, int bits, uint32_t value) {
    uint32_t coded = 1;  // The bits so far, behind a leading one.
    for (int i = bits - 1; i >= 0; --i) {
      const bool bit = (value >> i & 1) != 0;
      const bool learned = coded < (1u << kLearned);
      coded = coded << 1 | static_cast<uint32_t>(learned ? nodes_[coded].Code(coder, bit)
                                                         : coder.Bit(kEvenChance, bit));
    }
    return coded - (1u << bits);
  }

 private:
  std::array<AdaptiveBit, size_t{1} << kLearned> nodes_;
};

// Codes numbers that are small more often than large (Elias' gamma code with learned bits): how
// many bits value + 1 has, then these.
class SmallNumberModel {
 public:
  template <typename Coder>
  uint32_t Code(Coder& coder, uint32_t value) {
    const uint64_t more = uint64_t{value} + 1;
    const int wanted = static_cast<int>(std::bit_width(more)) - 1;
    int bits = 0;
    while (bits < kMaxBits && longer_[static_cast<size_t>(bits)].Code(coder, wanted > bits)) ++bits;
    const auto rest = static_cast<uint32_t>(more - (uint64_t{1} << wanted));
    // Up to 2^32, which a writer never gets to, is within 64 bits.
    return static_cast<uint32_t>((uint64_t{1} << bits) - 1 +
                                 rest_[static_cast<size_t>(bits)].Code(coder, bits, rest));
  }

 private:
  static constexpr int kMaxBits = 31;
  std::array<AdaptiveBit, kMaxBits> longer_;
  std::array<BitsModel<3>, kMaxBits + 1> rest_;
};

// Codes differences.
class DifferenceModel {
 public:
  template <typename Coder>
  int32_t Code(Coder& coder, int32_t value) {
    if (is_zero_.Code(coder, value == 0)) return 0;
    const bool negative = is_negative_.Code(coder, value < 0);
    // The magnitude of a value that isn't 0.
    const auto size = negative ? 0u - static_cast<uint32_t>(value) : static_cast<uint32_t>(value);
    const uint32_t coded = size_.Code(coder, size - 1) + 1;
    return static_cast<int32_t>(negative ? 0u - coded : coded);
  }

 private:
  AdaptiveBit is_zero_;
  AdaptiveBit is_negative_;
  SmallNumberModel size_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_ADAPTIVE_MODELS_H_
