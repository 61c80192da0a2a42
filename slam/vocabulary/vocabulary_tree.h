// The vocabulary tree as plain arrays (Nister and Stewenius, CVPR 2006; for binary features
// Galvez-Lopez and Tardos, T-RO 2012).
#ifndef CORBSLAM_SLAM_VOCABULARY_VOCABULARY_TREE_H_
#define CORBSLAM_SLAM_VOCABULARY_VOCABULARY_TREE_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "slam/features/keypoint.h"

namespace corbslam {

// Nodes are numbered breadth first, 0 is the root, so a node's children stand side by side. A word
// is a leaf and its id is the leaf's node number.
struct VocabularyTree {
  // Most children a node has, and the depth of the deepest leaf (the root has depth 0).
  uint32_t branching = 0;
  uint32_t levels = 0;
  // Depth of the nodes that the direct index groups features by.
  uint32_t direct_level = 0;
  // One descriptor a node; the root's is unused.
  std::vector<Descriptor> descriptors;
  // Node i's children are [first_child[i], first_child[i + 1]): one entry more than nodes.
  std::vector<uint32_t> first_child;
  // One weight a node: inverse document frequency of words, 0 for inner nodes.
  std::vector<float> weights;
};

// The same tree, wherever its arrays live.
struct VocabularyTreeView {
  uint32_t branching = 0;
  uint32_t levels = 0;
  uint32_t direct_level = 0;
  absl::Span<const Descriptor> descriptors;
  absl::Span<const uint32_t> first_child;
  absl::Span<const float> weights;

  VocabularyTreeView() = default;
  // `tree` must outlive the view.
  explicit VocabularyTreeView(const VocabularyTree& tree);
  uint32_t nodes() const { return static_cast<uint32_t>(descriptors.size()); }
  bool IsLeaf(uint32_t node) const { return first_child[node] == first_child[node + 1]; }
};

constexpr uint32_t kMaxBranching = 255;
constexpr uint32_t kMaxLevels = 16;
constexpr uint32_t kMaxVocabularyNodes = 1u << 27;

// INVALID_ARGUMENT, naming node and value, unless every descent from the root stays within the
// arrays and ends after `levels` steps at the latest. It reads first_child only.
absl::Status ValidateStructure(const VocabularyTreeView& tree);
// INVALID_ARGUMENT unless weights are finite and not negative.
absl::Status ValidateWeights(const VocabularyTreeView& tree);

// Returns a 64-bit digest of everything in the tree.
uint64_t ComputeFingerprint(const VocabularyTreeView& tree);

// Node and leaf in which one descriptor ends.
struct TreePath {
  uint32_t direct_node = 0;  // The node at direct_level, or the leaf if that is nearer to the root.
  uint32_t leaf = 0;
};
// Descends greedily to the nearest child, the first among equals. paths.size() must equal
// descriptors.size().
void DescendTree(const VocabularyTreeView& tree, absl::Span<const Descriptor> descriptors,
                 absl::Span<TreePath> paths);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VOCABULARY_VOCABULARY_TREE_H_
