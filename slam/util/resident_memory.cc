#include "slam/util/resident_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace corbslam {

uint64_t ResidentBytes() {
  uint64_t pages = 0;
  uint64_t resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

void ReturnFreeMemory() {
  // Giving less back is not worth holding up those who allocate meanwhile.
  constexpr uint64_t kLeast = uint64_t{128} << 20;
  ReturnFreeMemoryAbove(std::max(kLeast, ResidentBytes() / 8));
}

void ReturnFreeMemoryAbove(uint64_t least_bytes) {
#ifdef __GLIBC__
  const struct mallinfo2 allocated = mallinfo2();
  const uint64_t used = allocated.uordblks + allocated.hblkhd;
  if (ResidentBytes() > used + least_bytes) malloc_trim(0);
#else
  static_cast<void>(least_bytes);
#endif
}

}  // namespace corbslam
