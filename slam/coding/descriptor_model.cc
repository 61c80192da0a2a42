#include "slam/coding/descriptor_model.h"

#include <algorithm>
#include <cstdlib>

namespace corbslam {
namespace {

uint16_t ProbabilityOf(int log_odds) {
  constexpr int kQuarter = kLogOddsSteps / 4;
  const int size = std::min(std::abs(log_odds), kMostLogOdds);
  const int below = kProbabilityOfQuarters[static_cast<size_t>(size / kQuarter)];
  const int above = kProbabilityOfQuarters[static_cast<size_t>((size + kQuarter - 1) / kQuarter)];
  const int likelier = below + (above - below) * (size % kQuarter) / kQuarter;
  return static_cast<uint16_t>(log_odds < 0 ? 65536 - likelier : likelier);
}

}  // namespace

const ProbabilityTable& ProbabilitiesOfLogOdds() {
  static const ProbabilityTable* const table = [] {
    auto* made = new ProbabilityTable();
    for (int odds = INT16_MIN; odds <= INT16_MAX; ++odds) {
      (*made)[static_cast<uint16_t>(odds)] = ProbabilityOf(odds);
    }
    return made;
  }();
  return *table;
}

const BitWeights& LearnedBitWeights() {
  static const BitWeights* const weights = [] {
    auto* made = new BitWeights();
    std::ranges::copy(kLearnedBitBias, made->bias.begin());
    size_t next = 0;
    for (size_t j = 0; j < kDescriptorBits; ++j) {
      for (size_t k = j + 1; k < kDescriptorBits; ++k) {
        const int weight = kLearnedBitWeights[next++];
        // A 0 takes the weight away: that is a part of the bias, and a 1 gives it back twice.
        made->bias[k] = static_cast<uint16_t>(made->bias[k] - weight);
        made->after[j][k] = static_cast<uint16_t>(2 * weight);
      }
    }
    return made;
  }();
  return *weights;
}

}  // namespace corbslam
