#include "slam/util/heap_bytes.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_map.h"

namespace corbslam {
namespace {

struct HeldEntry {
  uint64_t values[3] = {};
};
using HeldPair = std::pair<const uint64_t, HeldEntry>;

uint64_t Allocated() {
  const struct mallinfo2 allocated = mallinfo2();
  return allocated.uordblks + allocated.hblkhd;
}

// Returns what the allocator gave for one container, as the mean of many: what its caches have is
// given without being counted.
template <typename Container, typename Fill>
double Measure(Fill fill) {
  constexpr int kContainers = 200;
  std::vector<std::unique_ptr<Container>> containers(kContainers);
  for (auto& container : containers) container = std::make_unique<Container>();
  const uint64_t before = Allocated();
  for (auto& container : containers) fill(*container);
  return static_cast<double>(Allocated() - before) / kContainers;
}

TEST(HeapBytesTest, OneBlockIsAsTheAllocatorGivesIt) {
  for (const uint64_t bytes : {1u, 24u, 25u, 100u, 1000u, 100'000u}) {
    const double taken = Measure<std::vector<char>>([&](auto& v) { v.resize(bytes); });
    EXPECT_NEAR(taken, static_cast<double>(HeapBlockBytes(bytes)), 2 + 0.02 * taken) << bytes;
  }
  EXPECT_EQ(HeapBlockBytes(0), 0u);
  EXPECT_EQ(VectorBytes(std::vector<int>()), 0u);
}

TEST(HeapBytesTest, ContainersTakeWhatIsSaid) {
  for (const uint64_t count : {0u, 1u, 2u, 3u, 7u, 8u, 20u, 100u, 1000u, 5000u}) {
    const auto fill = [&](auto& container) {
      for (uint64_t i = 0; i < count; ++i) container.emplace(i * 7919 % 10'007, HeldEntry());
    };
    const auto tree = static_cast<double>(TreeBytes<HeldPair>(count));
    EXPECT_NEAR((Measure<std::map<uint64_t, HeldEntry>>(fill)), tree, 0.02 * tree + 8) << count;
    const auto hash = static_cast<double>(HashTableBytes<HeldPair>(count));
    EXPECT_NEAR((Measure<absl::flat_hash_map<uint64_t, HeldEntry>>(fill)), hash, 0.05 * hash + 32)
        << count;
    const auto btree = static_cast<double>(BtreeBytes<HeldPair>(count));
    EXPECT_NEAR((Measure<absl::btree_map<uint64_t, HeldEntry>>(fill)), btree, 0.25 * btree + 32)
        << count;
  }
}

}  // namespace
}  // namespace corbslam
