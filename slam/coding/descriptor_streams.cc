#include "slam/coding/descriptor_streams.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "slam/coding/binary_coder.h"
#include "slam/coding/descriptor_model.h"

// The kernels are written once, as plain loops that compilers turn into vector code, and inlined
// into a function for each instruction set.
#define CORBSLAM_KERNEL [[gnu::always_inline]] inline

namespace corbslam {
namespace {

constexpr size_t kBits = kDescriptorBits;
constexpr size_t kBlock = 16;

template <typename Coder>
using Coders = std::array<Coder, kDescriptorStreams>;

// A block is sixteen log-odds that are added at once, by two instructions or by one.
using Block [[gnu::vector_size(2 * kBlock)]] = uint16_t;
constexpr size_t kBlocks = kBits / kBlock;

// A lane holds one descriptor on its way through a coder.
struct Lane {
  std::array<Block, kBlocks> log_odds;
  // Masks of the block under way: all ones for a bit that is 1.
  std::array<uint16_t, kBlock> masks;
};

struct Model {
  const BitWeights& weights;
  const ProbabilityTable& probabilities;
};

CORBSLAM_KERNEL void Load(const BitWeights& weights, size_t bit, size_t block, Block& after) {
  std::memcpy(&after, &weights.after[bit][block * kBlock], sizeof(after));
}

// Takes up what bits of a block say of another block.
CORBSLAM_KERNEL void Learn(const BitWeights& weights, size_t bit, size_t block, uint16_t mask,
                           Block& sums) {
  Block after;
  Load(weights, bit, block, after);
  sums += after & mask;
}

// Takes up a whole block in the block `later`, and in the three after it.
CORBSLAM_KERNEL void LearnInOne(const BitWeights& weights, size_t block, size_t later, Lane& lane) {
  Block sums = lane.log_odds[later];
  for (size_t i = 0; i < kBlock; ++i) {
    Learn(weights, block * kBlock + i, later, lane.masks[i], sums);
  }
  lane.log_odds[later] = sums;
}
CORBSLAM_KERNEL void LearnInFour(const BitWeights& weights, size_t block, size_t later,
                                 Lane& lane) {
  // Four named variables stay in registers; an array of them would be in memory.
  Block a = lane.log_odds[later];
  Block b = lane.log_odds[later + 1];
  Block c = lane.log_odds[later + 2];
  Block d = lane.log_odds[later + 3];
  for (size_t i = 0; i < kBlock; ++i) {
    const size_t bit = block * kBlock + i;
    Learn(weights, bit, later, lane.masks[i], a);
    Learn(weights, bit, later + 1, lane.masks[i], b);
    Learn(weights, bit, later + 2, lane.masks[i], c);
    Learn(weights, bit, later + 3, lane.masks[i], d);
  }
  lane.log_odds[later] = a;
  lane.log_odds[later + 1] = b;
  lane.log_odds[later + 2] = c;
  lane.log_odds[later + 3] = d;
}

// Takes up a whole block in all blocks after it, lane by lane while the weights are near.
template <size_t kLanes>
CORBSLAM_KERNEL void LearnBlock(const BitWeights& weights, size_t block,
                                std::array<Lane, kLanes>& lanes) {
  size_t later = block + 1;
  for (; later + 4 <= kBlocks; later += 4) {
    for (Lane& lane : lanes) LearnInFour(weights, block, later, lane);
  }
  for (; later < kBlocks; ++later) {
    for (Lane& lane : lanes) LearnInOne(weights, block, later, lane);
  }
}

// Codes bit after bit of one block, each taken up in the rest of it, in all lanes in turn.
template <size_t kLanes, typename Coder>
CORBSLAM_KERNEL void CodeBlock(const Model& model, size_t block, std::array<Lane, kLanes>& lanes,
                               Coder* coders, Descriptor* descriptors) {
  const size_t word = block * kBlock / 64;
  for (size_t i = 0; i < kBlock; ++i) {
    const size_t shift = (block * kBlock + i) % 64;
#pragma GCC unroll 4
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const uint32_t probability = model.probabilities[lanes[lane].log_odds[block][i]];
      uint64_t& bits = descriptors[lane].words[word];
      const bool bit = coders[lane].Bit(probability, (bits >> shift & 1) != 0);
      if constexpr (Coder::kReads) bits |= uint64_t{bit} << shift;
      const auto mask = static_cast<uint16_t>(-int{bit});
      lanes[lane].masks[i] = mask;
      Learn(model.weights, block * kBlock + i, block, mask, lanes[lane].log_odds[block]);
    }
  }
}

// Codes `kLanes` descriptors, the first of which is in the first of `coders`.
template <size_t kLanes, typename Coder>
CORBSLAM_KERNEL void CodeSome(const Model& model, Coder* coders, Descriptor* descriptors) {
  std::array<Lane, kLanes> lanes;
  for (Lane& lane : lanes) {
    std::memcpy(&lane.log_odds, &model.weights.bias, sizeof(lane.log_odds));
  }
  for (size_t block = 0; block < kBlocks; ++block) {
    CodeBlock(model, block, lanes, coders, descriptors);
    LearnBlock(model.weights, block, lanes);
  }
}

template <typename Coder>
CORBSLAM_KERNEL void CodeAll(Coders<Coder>& coders, std::span<Descriptor> descriptors) {
  const Model model = {LearnedBitWeights(), ProbabilitiesOfLogOdds()};
  size_t i = 0;
  for (; i + kDescriptorStreams <= descriptors.size(); i += kDescriptorStreams) {
    CodeSome<kDescriptorStreams>(model, coders.data(), &descriptors[i]);
  }
  for (; i < descriptors.size(); ++i) {
    CodeSome<1>(model, &coders[i % kDescriptorStreams], &descriptors[i]);
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
