#include "slam/vocabulary/hamming_kernels.h"

#include <algorithm>

// One body, compiled twice, chosen at run time. Debian's baseline x86-64 has no popcnt.
#if defined(__x86_64__)
#define CORBSLAM_POPCOUNT_CLONES 1
#endif

namespace corbslam {
namespace {

// Always inlined, so that it is compiled for the processor of its caller.
[[gnu::always_inline]] inline int Distance(const Descriptor& a, const Descriptor& b) {
  int distance = 0;
  for (size_t i = 0; i < 4; ++i) distance += __builtin_popcountll(a.words[i] ^ b.words[i]);
  return distance;
}

[[gnu::always_inline]] inline uint32_t Nearest(const Descriptor& descriptor,
                                               const Descriptor* candidates, uint32_t count) {
  uint32_t best = 0;
  int best_distance = 257;
  for (uint32_t i = 0; i < count; ++i) {
    const int distance = Distance(descriptor, candidates[i]);
    best = distance < best_distance ? i : best;
    best_distance = std::min(distance, best_distance);
  }
  return best;
}

[[gnu::always_inline]] inline void Descend(const VocabularyTreeView& tree,
                                           const Descriptor* descriptors, size_t count,
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

[[gnu::always_inline]] inline void Assign(const Descriptor* descriptors,
                                          absl::Span<const uint32_t> indices,
                                          absl::Span<const Descriptor> centres, uint8_t* nearest) {
  for (size_t i = 0; i < indices.size(); ++i) {
    nearest[i] = static_cast<uint8_t>(
        Nearest(descriptors[indices[i]], centres.data(), static_cast<uint32_t>(centres.size())));
  }
}

[[gnu::always_inline]] inline void Lower(const Descriptor* descriptors,
                                         absl::Span<const uint32_t> indices,
                                         const Descriptor& centre, uint16_t* distances) {
  for (size_t i = 0; i < indices.size(); ++i) {
    const auto distance = static_cast<uint16_t>(Distance(descriptors[indices[i]], centre));
    distances[i] = std::min(distances[i], distance);
  }
}

#ifdef CORBSLAM_POPCOUNT_CLONES
[[gnu::target("popcnt")]] void DescendPopcnt(const VocabularyTreeView& tree,
                                             const Descriptor* descriptors, size_t count,
                                             TreePath* paths) {
  Descend(tree, descriptors, count, paths);
}
[[gnu::target("popcnt")]] void AssignPopcnt(const Descriptor* descriptors,
                                            absl::Span<const uint32_t> indices,
                                            absl::Span<const Descriptor> centres,
                                            uint8_t* nearest) {
  Assign(descriptors, indices, centres, nearest);
}
[[gnu::target("popcnt")]] void LowerPopcnt(const Descriptor* descriptors,
                                           absl::Span<const uint32_t> indices,
                                           const Descriptor& centre, uint16_t* distances) {
  Lower(descriptors, indices, centre, distances);
}

bool HasPopcnt() {
  static const bool has = __builtin_cpu_supports("popcnt");
  return has;
}
#endif

}  // namespace

void DescendTreeKernel(const VocabularyTreeView& tree, const Descriptor* descriptors, size_t count,
                       TreePath* paths) {
#ifdef CORBSLAM_POPCOUNT_CLONES
  if (HasPopcnt()) return DescendPopcnt(tree, descriptors, count, paths);
#endif
  Descend(tree, descriptors, count, paths);
}

void AssignToNearest(const Descriptor* descriptors, absl::Span<const uint32_t> indices,
                     absl::Span<const Descriptor> centres, uint8_t* nearest) {
#ifdef CORBSLAM_POPCOUNT_CLONES
  if (HasPopcnt()) return AssignPopcnt(descriptors, indices, centres, nearest);
#endif
  Assign(descriptors, indices, centres, nearest);
}

void LowerDistances(const Descriptor* descriptors, absl::Span<const uint32_t> indices,
                    const Descriptor& centre, uint16_t* distances) {
#ifdef CORBSLAM_POPCOUNT_CLONES
  if (HasPopcnt()) return LowerPopcnt(descriptors, indices, centre, distances);
#endif
  Lower(descriptors, indices, centre, distances);
}

}  // namespace corbslam
