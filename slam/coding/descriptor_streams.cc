#include "slam/coding/descriptor_streams.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "slam/coding/binary_coder.h"
#include "slam/coding/descriptor_model.h"

// Written once, as plain loops that compilers turn into vector code, and inlined into a function
// for each instruction set.
#define CORBSLAM_KERNEL [[gnu::always_inline]] inline

namespace corbslam {
namespace {

constexpr size_t kBits = kDescriptorBits;
constexpr size_t kBlock = 16;

template <typename Coder>
using Coders = std::array<Coder, kDescriptorStreams>;

// Sixteen at once: by two instructions, or by one.
using Block [[gnu::vector_size(2 * kBlock)]] = int16_t;

// The log-odds of one descriptor on its way through a coder.
struct Lane {
  std::array<Block, kBits / kBlock> log_odds;
  // Of the block under way: 1 for a bit that is 1, -1 for one that is 0.
  std::array<int16_t, kBlock> signs;
};

CORBSLAM_KERNEL void Load(const int16_t* from, Block& block) {
  std::memcpy(&block, from, sizeof(block));
}

// Takes up bit `i` of a block in the rest of the block.
CORBSLAM_KERNEL void LearnInBlock(const BitWeights& weights, size_t block, size_t i, Lane& lane) {
  Block after;
  Load(&weights.after[block * kBlock + i][block * kBlock], after);
  lane.log_odds[block] += after * lane.signs[i];
}

// Takes up a whole block in all blocks after it.
CORBSLAM_KERNEL void LearnBlock(const BitWeights& weights, size_t block, Lane& lane) {
  for (size_t later = block + 1; later < kBits / kBlock; ++later) {
    Block sums = lane.log_odds[later];
    for (size_t i = 0; i < kBlock; ++i) {
      Block after;
      Load(&weights.after[block * kBlock + i][later * kBlock], after);
      sums += after * lane.signs[i];
    }
    lane.log_odds[later] = sums;
  }
}

// `kLanes` descriptors, the first of which is in the first of `coders`.
template <size_t kLanes, typename Coder>
CORBSLAM_KERNEL void CodeSome(const BitWeights& weights, Coder* coders, Descriptor* descriptors) {
  std::array<Lane, kLanes> lanes;
  for (Lane& lane : lanes) std::memcpy(&lane.log_odds, &weights.bias, sizeof(lane.log_odds));
  for (size_t block = 0; block < kBits / kBlock; ++block) {
    for (size_t i = 0; i < kBlock; ++i) {
      const size_t j = block * kBlock + i;
      for (size_t lane = 0; lane < kLanes; ++lane) {
        uint64_t& word = descriptors[lane].words[j / 64];
        const bool known = (word >> (j % 64) & 1) != 0;
        const bool bit = coders[lane].Bit(ProbabilityOf(lanes[lane].log_odds[block][i]), known);
        if constexpr (Coder::kReads) word |= uint64_t{bit} << (j % 64);
        lanes[lane].signs[i] = static_cast<int16_t>(2 * int{bit} - 1);
        LearnInBlock(weights, block, i, lanes[lane]);
      }
    }
    for (Lane& lane : lanes) LearnBlock(weights, block, lane);
  }
}

template <typename Coder>
CORBSLAM_KERNEL void CodeAll(Coders<Coder>& coders, std::span<Descriptor> descriptors) {
  const BitWeights& weights = LearnedBitWeights();
  size_t i = 0;
  for (; i + kDescriptorStreams <= descriptors.size(); i += kDescriptorStreams) {
    CodeSome<kDescriptorStreams>(weights, coders.data(), &descriptors[i]);
  }
  for (; i < descriptors.size(); ++i) {
    CodeSome<1>(weights, &coders[i % kDescriptorStreams], &descriptors[i]);
  }
}

template <typename Coder>
using CodeFunction = void (*)(Coders<Coder>&, std::span<Descriptor>);

template <typename Coder>
void CodePortably(Coders<Coder>& coders, std::span<Descriptor> descriptors) {
  CodeAll(coders, descriptors);
}

#ifdef __x86_64__
template <typename Coder>
[[gnu::target("avx2")]] void CodeByAvx2(Coders<Coder>& coders, std::span<Descriptor> descriptors) {
  CodeAll(coders, descriptors);
}
template <typename Coder>
CodeFunction<Coder> BestCode() {
  static const bool kSupported = __builtin_cpu_supports("avx2") != 0;
  return kSupported ? &CodeByAvx2<Coder> : &CodePortably<Coder>;
}
#else
template <typename Coder>
CodeFunction<Coder> BestCode() {
  return &CodePortably<Coder>;
}
#endif

std::array<std::string, kDescriptorStreams> Encode(CodeFunction<BitWriter> code,
                                                   std::span<const Descriptor> descriptors) {
  std::vector<Descriptor> copy(descriptors.begin(), descriptors.end());
  Coders<BitWriter> writers;
  code(writers, copy);
  std::array<std::string, kDescriptorStreams> streams;
  for (size_t i = 0; i < streams.size(); ++i) streams[i] = writers[i].Finish();
  return streams;
}

bool Decode(CodeFunction<BitReader> code,
            const std::array<std::string_view, kDescriptorStreams>& streams,
            std::span<Descriptor> descriptors) {
  std::ranges::fill(descriptors, Descriptor());
  Coders<BitReader> readers = {BitReader(streams[0]), BitReader(streams[1]), BitReader(streams[2]),
                               BitReader(streams[3])};
  code(readers, descriptors);
  return std::ranges::all_of(readers, [](const BitReader& reader) { return reader.done(); });
}

}  // namespace

std::array<std::string, kDescriptorStreams> EncodeDescriptors(
    std::span<const Descriptor> descriptors) {
  return Encode(BestCode<BitWriter>(), descriptors);
}

bool DecodeDescriptors(const std::array<std::string_view, kDescriptorStreams>& streams,
                       std::span<Descriptor> descriptors) {
  return Decode(BestCode<BitReader>(), streams, descriptors);
}

std::array<std::string, kDescriptorStreams> EncodeDescriptorsPortably(
    std::span<const Descriptor> descriptors) {
  return Encode(&CodePortably<BitWriter>, descriptors);
}

bool DecodeDescriptorsPortably(const std::array<std::string_view, kDescriptorStreams>& streams,
                               std::span<Descriptor> descriptors) {
  return Decode(&CodePortably<BitReader>, streams, descriptors);
}

}  // namespace corbslam
