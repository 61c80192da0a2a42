#include "slam/util/checksum_kernels.h"

#include <array>
#include <bit>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
// Clang 14 declares the instructions only in a build whose every processor has them.
#elif defined(__aarch64__) && (!defined(__clang__) || defined(__ARM_FEATURE_CRC32))
#include <arm_acle.h>
#include <asm/hwcap.h>
#include <sys/auxv.h>
#define CORBSLAM_ARM_CRC 1
#endif

namespace corbslam {
namespace {

static_assert(std::endian::native == std::endian::little, "words are taken as they lie");

using Tables = std::array<std::array<uint32_t, 256>, 8>;

// Table k has the register after a byte and k zero bytes.
constexpr Tables MakeTables() {
  Tables tables{};
  for (uint32_t byte = 0; byte < 256; ++byte) {
    uint32_t value = byte;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0x82f63b78u : 0u);
    tables[0][byte] = value;
  }
  for (size_t k = 1; k < tables.size(); ++k) {
    for (size_t byte = 0; byte < 256; ++byte) {
      const uint32_t before = tables[k - 1][byte];
      tables[k][byte] = (before >> 8) ^ tables[0][before & 0xffu];
    }
  }
  return tables;
}
constexpr Tables kTables = MakeTables();

#if defined(__x86_64__)

[[gnu::target("sse4.2")]] uint32_t BySse42(uint32_t state, const char* data, size_t size) {
  uint64_t wide = state;
  for (; size >= 8; data += 8, size -= 8) {
    uint64_t word = 0;
    std::memcpy(&word, data, 8);
    wide = _mm_crc32_u64(wide, word);
  }
  state = static_cast<uint32_t>(wide);
  for (; size > 0; ++data, --size) state = _mm_crc32_u8(state, static_cast<uint8_t>(*data));
  return state;
}

#elif defined(CORBSLAM_ARM_CRC)

[[gnu::target("+crc")]] uint32_t ByArmCrc(uint32_t state, const char* data, size_t size) {
  for (; size >= 8; data += 8, size -= 8) {
    uint64_t word = 0;
    std::memcpy(&word, data, 8);
    state = __crc32cd(state, word);
  }
  for (; size > 0; ++data, --size) state = __crc32cb(state, static_cast<uint8_t>(*data));
  return state;
}

#endif

}  // namespace

uint32_t Crc32cByTables(uint32_t state, const char* data, size_t size) {
  for (; size >= 8; data += 8, size -= 8) {
    uint64_t word = 0;
    std::memcpy(&word, data, 8);
    word ^= state;
    state = 0;
    for (size_t i = 0; i < 8; ++i) state ^= kTables[7 - i][word >> (8 * i) & 0xffu];
  }
  for (; size > 0; ++data, --size) {
    state = (state >> 8) ^ kTables[0][(state ^ static_cast<uint8_t>(*data)) & 0xffu];
  }
  return state;
}

Crc32cKernel Crc32cByInstructions() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("sse4.2") != 0 ? &BySse42 : nullptr;
#elif defined(CORBSLAM_ARM_CRC)
  return (getauxval(AT_HWCAP) & HWCAP_CRC32) != 0 ? &ByArmCrc : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace corbslam
