// The ways to compute CRC-32C: by tables, which every processor can, and by the processor's own
// instructions where it has them. All give the same bits. Internal to slam/util.
#ifndef CORBSLAM_SLAM_UTIL_CHECKSUM_KERNELS_H_
#define CORBSLAM_SLAM_UTIL_CHECKSUM_KERNELS_H_

#include <cstddef>
#include <cstdint>

namespace corbslam {

// Returns the register's next state after `size` bytes. The register holds the checksum's
// complement; `data` may lie at any address.
using Crc32cKernel = uint32_t (*)(uint32_t state, const char* data, size_t size);

// Takes eight bytes at a time by eight tables ("slicing-by-8", Kounavis and Berry, ISCC 2005).
uint32_t Crc32cByTables(uint32_t state, const char* data, size_t size);

// Returns the kernel by the instructions of this processor (SSE4.2 on x86-64, the CRC extension of
// ARMv8 on arm64), or null where the processor, or the compiler of this build, has none.
Crc32cKernel Crc32cByInstructions();

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_CHECKSUM_KERNELS_H_
