// Computes CRC-32C (Castagnoli), the polynomial of iSCSI (RFC 3720) and of the processor's own
// instruction.
#ifndef CORBSLAM_SLAM_UTIL_CHECKSUM_H_
#define CORBSLAM_SLAM_UTIL_CHECKSUM_H_

#include <cstdint>

#include "absl/strings/string_view.h"

namespace corbslam {

// Returns the checksum of what `crc` was of, followed by `data`. 0 is the checksum of nothing.
uint32_t ExtendCrc32c(uint32_t crc, absl::string_view data);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_CHECKSUM_H_
