#include "slam/util/resident_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace corbslam {
namespace {

// Anonymous memory that is no heap: stacks of threads.
constexpr uint64_t kStacks_bytes = uint64_t{16} << 20;

struct Resident {
  uint64_t all_bytes = 0;
  // Of programs and libraries, and shared with other processes.
  uint64_t files_bytes = 0;
};

Resident ReadResident() {
  uint64_t pages = 0;
  Resident resident;
  std::ifstream("/proc/self/statm") >> pages >> resident.all_bytes >> resident.files_bytes;
  const auto page = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return {resident.all_bytes * page, resident.files_bytes * page};
}

}  // namespace

uint64_t ResidentBytes() { return ReadResident().all_bytes; }

uint64_t UsedBytes() {
  const Resident resident = ReadResident();
#ifdef __GLIBC__
  const struct mallinfo2 allocated = mallinfo2();
  const uint64_t heap = allocated.uordblks + allocated.hblkhd;
  return std::min(resident.all_bytes, resident.files_bytes + heap + kStacks_bytes);
#else
  return resident.all_bytes;
#endif
}

uint64_t FreeHeapBytes() {
#ifdef __GLIBC__
  const Resident resident = ReadResident();
  const struct mallinfo2 allocated = mallinfo2();
  const uint64_t used = resident.files_bytes + allocated.uordblks + allocated.hblkhd;
  return resident.all_bytes > used ? resident.all_bytes - used : 0;
#else
  return 0;
#endif
}

bool HeapTrimmer::GiveBack() {
  const uint64_t kept = FreeHeapBytes();
  left_bytes_ = std::min(left_bytes_, kept);
  if (kept - left_bytes_ < least_bytes_) return false;
  ReturnFreeMemoryAbove(0);
  left_bytes_ = FreeHeapBytes();
  return true;
}

void ReturnFreeMemory() {
  // Giving less back is not worth holding up those who allocate meanwhile.
  constexpr uint64_t kLeast = uint64_t{128} << 20;
  ReturnFreeMemoryAbove(std::max(kLeast, ResidentBytes() / 8));
}

void ReturnFreeMemoryAbove(uint64_t least_bytes) {
#ifdef __GLIBC__
  if (FreeHeapBytes() > least_bytes) malloc_trim(0);
#else
  static_cast<void>(least_bytes);
#endif
}

}  // namespace corbslam
