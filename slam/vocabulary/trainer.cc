#include "slam/vocabulary/trainer.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/binary_clustering.h"

namespace corbslam {
namespace {

// A node of the level being built, and which of the indices are below it.
struct OpenNode {
  uint32_t node = 0;
  size_t begin = 0;
  size_t end = 0;
};

absl::Status CheckRange(const char* name, int64_t value, int64_t low, int64_t high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("training option ", name, " is ", value, ", not ", low, " to ", high));
}

std::vector<Descriptor> SampleDescriptors(const PictureDescriptors& pictures, size_t limit) {
  size_t total = 0;
  for (const auto& picture : pictures) total += picture.size();
  const size_t wanted = std::min(total, limit);
  std::vector<Descriptor> sample;
  sample.reserve(wanted);
  size_t seen = 0;
  for (const auto& picture : pictures) {
    for (const Descriptor& descriptor : picture) {
      // `wanted` of `total` are taken evenly: whenever the share due reaches the next whole number.
      if (++seen * wanted / total > sample.size()) sample.push_back(descriptor);
    }
  }
  return sample;
}

// Runs work(0) to work(count - 1), which must not depend on each other.
template <typename Work>
void RunParallel(int threads, size_t count, const Work& work) {
  std::vector<std::thread> others;
  const auto run = [&](size_t first) {
    for (size_t i = first; i < count; i += static_cast<size_t>(threads)) work(i);
  };
  for (int t = 1; t < threads; ++t) others.emplace_back(run, static_cast<size_t>(t));
  run(0);
  for (std::thread& other : others) other.join();
}

// Splits the nodes of one level and appends their children to `tree`; returns those.
std::vector<OpenNode> SplitLevel(const TrainingOptions& options,
                                 const std::vector<Descriptor>& sample,
                                 const std::vector<OpenNode>& level, std::vector<uint32_t>& indices,
                                 VocabularyTree& tree) {
  std::vector<BinaryClusters> clusters(level.size());
  RunParallel(options.threads, level.size(), [&](size_t i) {
    const OpenNode& open = level[i];
    const size_t size = open.end - open.begin;
    if (size < static_cast<size_t>(options.min_descriptors_to_split)) return;
    // The seed depends on the node's number, so that neither order nor threads matter.
    const uint64_t seed = options.seed * 0x9e3779b97f4a7c15u + open.node;
    clusters[i] = ClusterDescriptors(sample, absl::MakeSpan(indices).subspan(open.begin, size),
                                     options.branching, options.max_iterations, seed);
  });

  std::vector<OpenNode> children;
  for (size_t i = 0; i < level.size(); ++i) {
    tree.first_child.push_back(static_cast<uint32_t>(tree.descriptors.size()));
    // One child would say no more than its parent.
    if (clusters[i].centres.size() < 2) continue;
    size_t begin = level[i].begin;
    for (size_t c = 0; c < clusters[i].centres.size(); ++c) {
      const auto node = static_cast<uint32_t>(tree.descriptors.size());
      children.push_back({node, begin, begin + clusters[i].sizes[c]});
      tree.descriptors.push_back(clusters[i].centres[c]);
      begin += clusters[i].sizes[c];
    }
  }
  return children;
}

// A word's weight is ln(pictures / pictures that show it); a word that none shows is as rare as can
// be.
void ComputeWeights(const TrainingOptions& options, const PictureDescriptors& pictures,
                    VocabularyTree& tree) {
  const VocabularyTreeView view(tree);
  std::vector<std::vector<TreePath>> paths(pictures.size());
  RunParallel(options.threads, pictures.size(), [&](size_t i) {
    paths[i].resize(pictures[i].size());
    DescendTree(view, pictures[i], absl::MakeSpan(paths[i]));
  });
  std::vector<uint32_t> shown_by(view.nodes(), 0);
  std::vector<size_t> last(view.nodes(), pictures.size());
  for (size_t i = 0; i < pictures.size(); ++i) {
    for (const TreePath& path : paths[i]) {
      shown_by[path.leaf] += last[path.leaf] != i;
      last[path.leaf] = i;
    }
  }
  for (uint32_t node = 0; node < view.nodes(); ++node) {
    if (!view.IsLeaf(node)) continue;
    const uint32_t shown = std::max(shown_by[node], 1u);
    tree.weights[node] = static_cast<float>(
        std::log(static_cast<double>(pictures.size()) / static_cast<double>(shown)));
  }
}

}  // namespace

absl::Status TrainingOptions::Validate() const {
  RETURN_IF_ERROR(CheckRange("branching", branching, 2, kMaxBranching));
  RETURN_IF_ERROR(CheckRange("levels", levels, 1, kMaxLevels));
  RETURN_IF_ERROR(CheckRange("direct_level", direct_level, 0, levels));
  RETURN_IF_ERROR(CheckRange("max_iterations", max_iterations, 1, 1000));
  RETURN_IF_ERROR(CheckRange("min_descriptors_to_split", min_descriptors_to_split, 2, 1 << 30));
  RETURN_IF_ERROR(CheckRange("max_descriptors", static_cast<int64_t>(max_descriptors), 2, 1 << 30));
  return CheckRange("threads", threads, 1, 256);
}

absl::StatusOr<VocabularyTree> TrainVocabulary(const TrainingOptions& options,
                                               const PictureDescriptors& pictures,
                                               const TrainingProgress& progress) {
  RETURN_IF_ERROR(options.Validate());
  const std::vector<Descriptor> sample = SampleDescriptors(pictures, options.max_descriptors);
  std::vector<uint32_t> indices(sample.size());
  std::iota(indices.begin(), indices.end(), 0u);

  VocabularyTree tree;
  tree.branching = static_cast<uint32_t>(options.branching);
  tree.descriptors.emplace_back();
  std::vector<OpenNode> level = {{0, 0, sample.size()}};
  while (!level.empty()) {
    if (progress) progress("clustering", tree.levels, static_cast<size_t>(options.levels));
    if (tree.levels == static_cast<uint32_t>(options.levels)) {
      tree.first_child.insert(tree.first_child.end(), level.size(),
                              static_cast<uint32_t>(tree.descriptors.size()));
      break;
    }
    level = SplitLevel(options, sample, level, indices, tree);
    tree.levels += !level.empty();
  }
  tree.first_child.push_back(static_cast<uint32_t>(tree.descriptors.size()));
  tree.direct_level = std::min(static_cast<uint32_t>(options.direct_level), tree.levels);
  tree.weights.assign(tree.descriptors.size(), 0.0f);
  if (tree.levels == 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        sample.size(), " descriptors of ", pictures.size(), " pictures do not make two words"));
  }
  ComputeWeights(options, pictures, tree);
  RETURN_IF_ERROR(ValidateStructure(VocabularyTreeView(tree)));
  return tree;
}

}  // namespace corbslam
