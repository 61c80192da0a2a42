#include "slam/util/checksum.h"

#include "slam/util/checksum_kernels.h"

namespace corbslam {
namespace {

Crc32cKernel ChooseKernel() {
  const Crc32cKernel fast = Crc32cByInstructions();
  return fast != nullptr ? fast : &Crc32cByTables;
}

}  // namespace

uint32_t ExtendCrc32c(uint32_t crc, absl::string_view data) {
  static const Crc32cKernel kernel = ChooseKernel();
  return ~kernel(~crc, data.data(), data.size());
}

}  // namespace corbslam
