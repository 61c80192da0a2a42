#include "slam/vocabulary/vocabulary_tree.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "slam/vocabulary/hamming_kernels.h"

namespace corbslam {
namespace {

absl::Status CheckSizes(const VocabularyTreeView& tree) {
  const size_t nodes = tree.descriptors.size();
  if (nodes < 2 || nodes > kMaxVocabularyNodes) {
    return absl::InvalidArgumentError(
        absl::StrCat("vocabulary has ", nodes, " nodes, not 2 to ", kMaxVocabularyNodes));
  }
  if (tree.first_child.size() != nodes + 1 || tree.weights.size() != nodes) {
    return absl::InvalidArgumentError(absl::StrCat("vocabulary of ", nodes, " nodes has ",
                                                   tree.first_child.size(), " child ranges and ",
                                                   tree.weights.size(), " weights"));
  }
  if (tree.branching < 2 || tree.branching > kMaxBranching) {
    return absl::InvalidArgumentError(
        absl::StrCat("branching is ", tree.branching, ", not 2 to ", kMaxBranching));
  }
  if (tree.levels < 1 || tree.levels > kMaxLevels || tree.direct_level > tree.levels) {
    return absl::InvalidArgumentError(absl::StrCat("levels are ", tree.levels, ", not 1 to ",
                                                   kMaxLevels, "; direct level is ",
                                                   tree.direct_level, ", not 0 to levels"));
  }
  return absl::OkStatus();
}

// Nodes are numbered breadth first: a level's nodes are side by side, and so are their children.
uint32_t CountLevels(const VocabularyTreeView& tree) {
  uint32_t levels = 0;
  uint32_t begin = 0;
  uint32_t end = 1;
  while (tree.first_child[end] > tree.first_child[begin]) {
    const uint32_t next_begin = tree.first_child[begin];
    end = tree.first_child[end];
    begin = next_begin;
    ++levels;
  }
  return levels;
}

uint64_t Mix(uint64_t digest, uint64_t value) {
  // Multiplication by an odd number and a rotation are invertible: each flipped bit shows.
  return std::rotl((digest ^ value) * 0x9e3779b97f4a7c15u, 29);
}

uint64_t MixBytes(uint64_t digest, const void* data, size_t size) {
  const char* bytes = static_cast<const char*>(data);
  for (; size >= 8; bytes += 8, size -= 8) {
    uint64_t value = 0;
    std::memcpy(&value, bytes, 8);
    digest = Mix(digest, value);
  }
  uint64_t rest = 0;
  std::memcpy(&rest, bytes, size);
  return Mix(digest, rest);
}

}  // namespace

VocabularyTreeView::VocabularyTreeView(const VocabularyTree& tree)
    : branching(tree.branching),
      levels(tree.levels),
      direct_level(tree.direct_level),
      descriptors(tree.descriptors),
      first_child(tree.first_child),
      weights(tree.weights) {}

absl::Status ValidateStructure(const VocabularyTreeView& tree) {
  if (absl::Status status = CheckSizes(tree); !status.ok()) return status;
  const uint32_t nodes = tree.nodes();
  if (tree.first_child[0] != 1 || tree.first_child[nodes] != nodes) {
    return absl::InvalidArgumentError(absl::StrCat("children range from ", tree.first_child[0],
                                                   " to ", tree.first_child[nodes],
                                                   ", not from 1 to ", nodes));
  }
  for (uint32_t node = 0; node < nodes; ++node) {
    const uint32_t begin = tree.first_child[node];
    const uint32_t end = tree.first_child[node + 1];
    if (begin <= node || end < begin || end - begin > tree.branching) {
      return absl::InvalidArgumentError(absl::StrCat("node ", node, " has children ", begin, " to ",
                                                     end, "; branching is ", tree.branching));
    }
  }
  const uint32_t levels = CountLevels(tree);
  if (levels != tree.levels) {
    return absl::InvalidArgumentError(
        absl::StrCat("vocabulary has ", levels, " levels, not ", tree.levels));
  }
  return absl::OkStatus();
}

absl::Status ValidateWeights(const VocabularyTreeView& tree) {
  for (uint32_t node = 0; node < tree.nodes(); ++node) {
    const float weight = tree.weights[node];
    if (!std::isfinite(weight) || weight < 0) {
      return absl::InvalidArgumentError(absl::StrCat("node ", node, " has weight ", weight));
    }
  }
  return absl::OkStatus();
}

uint64_t ComputeFingerprint(const VocabularyTreeView& tree) {
  uint64_t digest = Mix(tree.branching, tree.levels);
  digest = Mix(digest, tree.direct_level);
  digest = Mix(digest, tree.descriptors.size());
  digest = MixBytes(digest, tree.descriptors.data(), tree.descriptors.size() * sizeof(Descriptor));
  digest = MixBytes(digest, tree.first_child.data(), tree.first_child.size() * sizeof(uint32_t));
  return MixBytes(digest, tree.weights.data(), tree.weights.size() * sizeof(float));
}

void DescendTree(const VocabularyTreeView& tree, absl::Span<const Descriptor> descriptors,
                 absl::Span<TreePath> paths) {
  DescendTreeKernel(tree, descriptors.data(), descriptors.size(), paths.data());
}

}  // namespace corbslam
