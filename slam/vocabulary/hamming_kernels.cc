#include "slam/vocabulary/hamming_kernels.h"

#include <algorithm>

namespace corbslam {
namespace {

uint32_t Nearest(const Descriptor& descriptor, const Descriptor* candidates, uint32_t count) {
  uint32_t best = 0;
  int best_distance = 257;
  for (uint32_t i = 0; i < count; ++i) {
    const int distance = HammingDistance(descriptor, candidates[i]);
    best = distance < best_distance ? i : best;
    best_distance = std::min(distance, best_distance);
  }
  return best;
}

}  // namespace

void DescendTreeKernel(const VocabularyTreeView& tree, const Descriptor* descriptors, size_t count,
                       TreePath* paths) {
  const Descriptor* const centres = tree.descriptors.data();
  const uint32_t* const first_child = tree.first_child.data();
  for (size_t i = 0; i < count; ++i) {
    uint32_t node = 0;
    uint32_t direct_node = 0;
    for (uint32_t depth = 0;; ++depth) {
      if (depth <= tree.direct_level) direct_node = node;
      const uint32_t begin = first_child[node];
      const uint32_t children = first_child[node + 1] - begin;
      if (children == 0) break;
      node = begin + Nearest(descriptors[i], centres + begin, children);
    }
    paths[i] = {direct_node, node};
  }
}

void AssignToNearest(const Descriptor* descriptors, absl::Span<const uint32_t> indices,
                     absl::Span<const Descriptor> centres, uint8_t* nearest) {
  for (size_t i = 0; i < indices.size(); ++i) {
    nearest[i] = static_cast<uint8_t>(
        Nearest(descriptors[indices[i]], centres.data(), static_cast<uint32_t>(centres.size())));
  }
}

void LowerDistances(const Descriptor* descriptors, absl::Span<const uint32_t> indices,
                    const Descriptor& centre, uint16_t* distances) {
  for (size_t i = 0; i < indices.size(); ++i) {
    const auto distance = static_cast<uint16_t>(HammingDistance(descriptors[indices[i]], centre));
    distances[i] = std::min(distances[i], distance);
  }
}

}  // namespace corbslam
