#include "slam/coding/descriptor_model.h"

#include <algorithm>
#include <memory>

namespace corbslam {

const BitWeights& LearnedBitWeights() {
  static const BitWeights* const weights = [] {
    auto* made = new BitWeights();
    std::ranges::copy(kLearnedBitBias, made->bias.begin());
    size_t next = 0;
    for (size_t j = 0; j < kDescriptorBits; ++j) {
      for (size_t k = j + 1; k < kDescriptorBits; ++k) {
        made->after[j][k] = kLearnedBitWeights[next++];
      }
    }
    return made;
  }();
  return *weights;
}

}  // namespace corbslam
