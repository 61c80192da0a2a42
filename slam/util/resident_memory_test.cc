#include "slam/util/resident_memory.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

namespace corbslam {
namespace {

// Small pieces, of which the first and the last stay: the allocator itself gives nothing back then.
class ResidentMemoryTest : public ::testing::Test {
 protected:
  static constexpr size_t kPieces = 400'000;
  static constexpr size_t kBytes = 1000;
  static constexpr uint64_t kAll_bytes = kPieces * kBytes;

  void Take() {
    pieces_.reserve(kPieces);
    for (size_t i = 0; i < kPieces; ++i) {
      pieces_.push_back(std::make_unique_for_overwrite<char[]>(kBytes));
      std::memset(pieces_.back().get(), 1, kBytes);
    }
  }
  void FreeAllBetween() {
    for (size_t i = 1; i + 1 < kPieces; ++i) pieces_[i].reset();
  }

  std::vector<std::unique_ptr<char[]>> pieces_;
};

TEST_F(ResidentMemoryTest, WhatWasFreedGoesBackThoughSomethingLiesAboveIt) {
  const uint64_t before = ResidentBytes();
  Take();
  ASSERT_GT(ResidentBytes(), before + kAll_bytes / 2);
  FreeAllBetween();
  {
    const ReturnsFreeMemory after;
    EXPECT_GT(ResidentBytes(), before + kAll_bytes / 2) << "kept until then";
    EXPECT_LT(UsedBytes(), before + kAll_bytes / 4) << "what is kept is not used";
    EXPECT_GT(FreeHeapBytes(), kAll_bytes / 2);
  }
  EXPECT_LT(ResidentBytes(), before + kAll_bytes / 4);
  EXPECT_LT(FreeHeapBytes(), kAll_bytes / 4);
}

TEST_F(ResidentMemoryTest, WhatIsKeptGoesBackOnceItIsMore) {
  const uint64_t before = ResidentBytes();
  Take();
  // Every fourth stays, and with it its page.
  for (size_t i = 0; i < kPieces; ++i) {
    if (i % 4 != 0) pieces_[i].reset();
  }
  HeapTrimmer kept(kAll_bytes / 8);
  EXPECT_TRUE(kept.GiveBack());
  EXPECT_GT(FreeHeapBytes(), kAll_bytes / 8) << "of pages that something lies in";
  EXPECT_FALSE(kept.GiveBack()) << "none of that can be had";
  for (size_t i = 4; i + 4 < kPieces; i += 4) pieces_[i].reset();
  EXPECT_TRUE(kept.GiveBack());
  EXPECT_LT(ResidentBytes(), before + kAll_bytes / 4);
}

}  // namespace
}  // namespace corbslam
