// Computes CRC-32 as zip, PNG and MCAP have it: the reflected polynomial 0xedb88320.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_CRC32_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_CRC32_H_

#include <cstdint>

#include "absl/strings/string_view.h"

namespace corbslam::services {

// Returns the checksum of what `crc` was of, followed by `data`. 0 is the checksum of nothing.
uint32_t ExtendCrc32(uint32_t crc, absl::string_view data);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_CRC32_H_
