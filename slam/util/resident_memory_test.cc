#include "slam/util/resident_memory.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

namespace corbslam {
namespace {

// Small pieces, of which the first and the last stay: the allocator itself gives nothing back then.
TEST(ResidentMemoryTest, WhatWasFreedGoesBackThoughSomethingLiesAboveIt) {
  constexpr size_t kPieces = 400'000;
  constexpr size_t kBytes = 1000;
  std::vector<std::unique_ptr<char[]>> pieces;
  pieces.reserve(kPieces);
  const uint64_t before = ResidentBytes();
  for (size_t i = 0; i < kPieces; ++i) {
    pieces.push_back(std::make_unique_for_overwrite<char[]>(kBytes));
    std::memset(pieces.back().get(), 1, kBytes);
  }
  const uint64_t full = ResidentBytes();
  ASSERT_GT(full, before + kPieces * kBytes / 2);
  for (size_t i = 1; i + 1 < kPieces; ++i) pieces[i].reset();
  {
    const ReturnsFreeMemory after;
    EXPECT_GT(ResidentBytes(), before + kPieces * kBytes / 2) << "kept until then";
    EXPECT_LT(UsedBytes(), before + kPieces * kBytes / 4) << "what is kept is not used";
  }
  EXPECT_LT(ResidentBytes(), before + kPieces * kBytes / 4);
}

}  // namespace
}  // namespace corbslam
