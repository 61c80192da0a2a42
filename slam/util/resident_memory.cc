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
#ifdef __GLIBC__
  // Giving less back is not worth holding up those who allocate meanwhile.
  constexpr uint64_t kLeast = uint64_t{128} << 20;
  const uint64_t resident = ResidentBytes();
  const struct mallinfo2 allocated = mallinfo2();
  const uint64_t used = allocated.uordblks + allocated.hblkhd;
  if (resident > used + std::max(kLeast, resident / 8)) malloc_trim(0);
#endif
}

}  // namespace corbslam
