// Arithmetic coding of bits whose probabilities both sides know (Witten, Neal, Cleary, CACM 1987),
// with 64-bit bounds that move on by 32 bits. Models are written once, as templates over the two
// classes: Bit(probability, bit) takes the bit where it writes, and says it where it reads.
#ifndef CORBSLAM_SLAM_CODING_BINARY_CODER_H_
#define CORBSLAM_SLAM_CODING_BINARY_CODER_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace corbslam {

// Probabilities that a bit is 1 are in 65536ths, 1 to 65535.
inline constexpr uint32_t kEvenChance = 1u << 15;

// Narrows the bounds to those after a bit. It selects by a mask, because a processor often
// mispredicts a jump on the bit that is about to be learned.
inline void Narrow(bool bit, uint64_t middle, uint64_t& low, uint64_t& high) {
  const uint64_t is_one = uint64_t{0} - uint64_t{bit};
  low += (middle + 1 - low) & ~is_one;
  high -= (high - middle) & is_one;
}

class BitWriter {
 public:
  static constexpr bool kReads = false;

  bool Bit(uint32_t one_in_65536, bool bit) {
    const uint64_t middle = low_ + ((high_ - low_) >> 16) * one_in_65536;
    Narrow(bit, middle, low_, high_);
    if ((low_ ^ high_) >> 32 == 0) [[unlikely]]
      MoveOn();
    return bit;
  }

  // Returns all that was written; the writer can't be used after it.
  std::string Finish() {
    // The upper halves of the bounds differ: this value lies between them, whatever follows it.
    Put(static_cast<uint32_t>(low_ >> 32) + 1);
    return std::move(bytes_);
  }

 private:
  // Writes the upper halves of the bounds once they agree. It is called rarely and stays out of
  // line.
  [[gnu::noinline]] void MoveOn() {
    do {
      Put(static_cast<uint32_t>(high_ >> 32));
      low_ <<= 32;
      high_ = high_ << 32 | 0xffffffffu;
    } while ((low_ ^ high_) >> 32 == 0);
  }
  void Put(uint32_t word) {
    for (int shift = 24; shift >= 0; shift -= 8) {
      bytes_.push_back(static_cast<char>(word >> shift & 0xff));
    }
  }

  uint64_t low_ = 0;
  uint64_t high_ = ~uint64_t{0};
  std::string bytes_;
};

// Reads any bytes as some bits, never beyond their end: what is missing there is taken as 0.
class BitReader {
 public:
  static constexpr bool kReads = true;

  explicit BitReader(std::string_view bytes) : bytes_(bytes) {
    value_ = Take();
    value_ = value_ << 32 | Take();
  }

  bool Bit(uint32_t one_in_65536, bool = false) {
    const uint64_t middle = low_ + ((high_ - low_) >> 16) * one_in_65536;
    const bool bit = value_ <= middle;
    Narrow(bit, middle, low_, high_);
    if ((low_ ^ high_) >> 32 == 0) [[unlikely]]
      MoveOn();
    return bit;
  }

  // True when more was read than a writer of these bits would have written.
  bool exhausted() const { return words_ > bytes_.size() / 4 + 1; }
  // True when exactly what a writer of these bits has written was read.
  bool done() const { return bytes_.size() % 4 == 0 && words_ == bytes_.size() / 4 + 1; }

 private:
  [[gnu::noinline]] void MoveOn() {
    do {
      low_ <<= 32;
      high_ = high_ << 32 | 0xffffffffu;
      value_ = value_ << 32 | Take();
    } while ((low_ ^ high_) >> 32 == 0);
  }
  uint32_t Take() {
    const size_t begin = 4 * words_++;
    if (begin + 4 > bytes_.size()) return 0;
    uint32_t word = 0;
    for (size_t i = begin; i < begin + 4; ++i) word = word << 8 | static_cast<uint8_t>(bytes_[i]);
    return word;
  }

  std::string_view bytes_;
  size_t words_ = 0;
  uint64_t low_ = 0;
  uint64_t high_ = ~uint64_t{0};
  uint64_t value_ = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_BINARY_CODER_H_
