#include "slam/vocabulary/binary_clustering.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <random>
#include <utility>

#include "slam/vocabulary/hamming_kernels.h"

namespace corbslam {
namespace {

static_assert(std::endian::native == std::endian::little);

// Makes a table in which entry b has bit i of b in its byte i.
constexpr std::array<uint64_t, 256> MakeSpread() {
  std::array<uint64_t, 256> spread = {};
  for (size_t byte = 0; byte < 256; ++byte) {
    for (size_t bit = 0; bit < 8; ++bit) spread[byte] |= uint64_t{(byte >> bit) & 1} << (8 * bit);
  }
  return spread;
}
constexpr std::array<uint64_t, 256> kSpread = MakeSpread();

// Counts for each of the 256 bits how often it was set; bytes first, to add eight at a time.
class BitCounter {
 public:
  void Add(const Descriptor& descriptor) {
    for (size_t i = 0; i < 32; ++i) {
      bytes_[i] += kSpread[(descriptor.words[i / 8] >> (8 * (i % 8))) & 0xff];
    }
    ++added_;
    if (++unflushed_ == 255) Flush();
  }

  // Returns the bits set in more than half; where exactly half have it, the bit of `otherwise`.
  Descriptor Majority(const Descriptor& otherwise) {
    Flush();
    Descriptor majority;
    for (size_t bit = 0; bit < 256; ++bit) {
      const uint64_t before = (otherwise.words[bit / 64] >> (bit % 64)) & 1;
      const uint64_t twice = uint64_t{2} * counts_[bit];
      const uint64_t set = twice == added_ ? before : uint64_t{twice > added_};
      majority.words[bit / 64] |= set << (bit % 64);
    }
    return majority;
  }

 private:
  void Flush() {
    for (size_t bit = 0; bit < 256; ++bit) {
      counts_[bit] += static_cast<uint32_t>((bytes_[bit / 8] >> (8 * (bit % 8))) & 0xff);
    }
    bytes_ = {};
    unflushed_ = 0;
  }

  std::array<uint64_t, 32> bytes_ = {};
  std::array<uint32_t, 256> counts_ = {};
  uint64_t added_ = 0;
  int unflushed_ = 0;
};

// Chooses each next seed with probability in proportion to its squared distance from the seeds so
// far.
std::vector<Descriptor> ChooseSeeds(absl::Span<const Descriptor> descriptors,
                                    absl::Span<const uint32_t> indices, size_t count,
                                    uint64_t seed) {
  // The standard fixes this generator's numbers, not those of its distributions.
  std::mt19937_64 random(seed);
  std::vector<Descriptor> centres = {descriptors[indices[random() % indices.size()]]};
  std::vector<uint16_t> distances(indices.size(), std::numeric_limits<uint16_t>::max());
  while (centres.size() < count) {
    LowerDistances(descriptors.data(), indices, centres.back(), distances.data());
    uint64_t sum = 0;
    for (const uint64_t distance : distances) sum += distance * distance;
    if (sum == 0) break;
    uint64_t rest = random() % sum;
    size_t chosen = 0;
    for (;; ++chosen) {
      const uint64_t squared = uint64_t{distances[chosen]} * distances[chosen];
      if (rest < squared) break;
      rest -= squared;
    }
    centres.push_back(descriptors[indices[chosen]]);
  }
  return centres;
}

// Centres that lost all their descriptors, or became equal to an earlier one, are dropped.
std::vector<Descriptor> MoveCentres(absl::Span<const Descriptor> descriptors,
                                    absl::Span<const uint32_t> indices,
                                    const std::vector<uint8_t>& nearest,
                                    const std::vector<Descriptor>& centres) {
  std::vector<BitCounter> counters(centres.size());
  std::vector<bool> used(centres.size(), false);
  for (size_t i = 0; i < indices.size(); ++i) {
    counters[nearest[i]].Add(descriptors[indices[i]]);
    used[nearest[i]] = true;
  }
  std::vector<Descriptor> moved;
  for (size_t c = 0; c < centres.size(); ++c) {
    if (!used[c]) continue;
    const Descriptor majority = counters[c].Majority(centres[c]);
    if (std::find(moved.begin(), moved.end(), majority) == moved.end()) moved.push_back(majority);
  }
  return moved;
}

BinaryClusters SortByCentre(absl::Span<uint32_t> indices, const std::vector<uint8_t>& nearest,
                            const std::vector<Descriptor>& centres) {
  std::vector<std::vector<uint32_t>> members(centres.size());
  for (size_t i = 0; i < indices.size(); ++i) members[nearest[i]].push_back(indices[i]);
  BinaryClusters clusters;
  auto next = indices.begin();
  for (size_t c = 0; c < centres.size(); ++c) {
    if (members[c].empty()) continue;
    clusters.centres.push_back(centres[c]);
    clusters.sizes.push_back(static_cast<uint32_t>(members[c].size()));
    next = std::copy(members[c].begin(), members[c].end(), next);
  }
  return clusters;
}

}  // namespace

BinaryClusters ClusterDescriptors(absl::Span<const Descriptor> descriptors,
                                  absl::Span<uint32_t> indices, int count, int max_iterations,
                                  uint64_t seed) {
  if (indices.empty()) return {};
  std::vector<Descriptor> centres =
      ChooseSeeds(descriptors, indices, static_cast<size_t>(count), seed);
  std::vector<uint8_t> nearest(indices.size());
  AssignToNearest(descriptors.data(), indices, centres, nearest.data());
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    std::vector<Descriptor> moved = MoveCentres(descriptors, indices, nearest, centres);
    if (moved == centres) break;
    centres = std::move(moved);
    AssignToNearest(descriptors.data(), indices, centres, nearest.data());
  }
  return SortByCentre(indices, nearest, centres);
}

}  // namespace corbslam
