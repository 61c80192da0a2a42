#include "slam/vocabulary/vocabulary.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary_file.h"

namespace corbslam {
namespace {

size_t CountWords(const VocabularyTreeView& tree) {
  size_t words = 0;
  for (uint32_t node = 0; node < tree.nodes(); ++node) words += tree.IsLeaf(node);
  return words;
}

BagOfWords MakeBag(const VocabularyTreeView& tree, const std::vector<TreePath>& paths) {
  std::vector<uint32_t> leaves;
  leaves.reserve(paths.size());
  for (const TreePath& path : paths) leaves.push_back(path.leaf);
  std::sort(leaves.begin(), leaves.end());

  BagOfWords bag;
  double sum = 0;
  for (size_t begin = 0, end = 0; begin < leaves.size(); begin = end) {
    while (end < leaves.size() && leaves[end] == leaves[begin]) ++end;
    const float idf = tree.weights[leaves[begin]];
    // A damaged file may hold anything here.
    if (!(idf > 0) || !std::isfinite(idf)) continue;
    bag.push_back({leaves[begin], static_cast<float>(end - begin) * idf});
    sum += bag.back().weight;
  }
  for (WordWeight& word : bag) word.weight = static_cast<float>(word.weight / sum);
  // Keyframes keep it.
  bag.shrink_to_fit();
  return bag;
}

std::vector<NodeFeatures> MakeDirectIndex(const std::vector<TreePath>& paths) {
  std::vector<std::pair<uint32_t, uint32_t>> features;
  features.reserve(paths.size());
  for (uint32_t i = 0; i < paths.size(); ++i) features.emplace_back(paths[i].direct_node, i);
  std::sort(features.begin(), features.end());

  std::vector<NodeFeatures> index;
  for (size_t begin = 0, end = 0; begin < features.size(); begin = end) {
    const uint32_t node = features[begin].first;
    while (end < features.size() && features[end].first == node) ++end;
    index.push_back({node, {}});
    index.back().features.reserve(end - begin);
    for (size_t i = begin; i < end; ++i) index.back().features.push_back(features[i].second);
  }
  index.shrink_to_fit();
  return index;
}

}  // namespace

Vocabulary::Vocabulary(VocabularyTree tree, std::unique_ptr<const MappedFile> file)
    : tree_(std::move(tree)), file_(std::move(file)) {}

Vocabulary::~Vocabulary() = default;

absl::StatusOr<std::shared_ptr<const Vocabulary>> Vocabulary::Load(const std::string& path) {
  ASSIGN_OR_RETURN(std::unique_ptr<const MappedFile> file, MappedFile::Open(path));
  ASSIGN_OR_RETURN(const VocabularyFileContent content, ParseVocabulary(*file));
  std::shared_ptr<Vocabulary> vocabulary(new Vocabulary({}, std::move(file)));
  vocabulary->view_ = content.tree;
  vocabulary->words_ = content.words;
  vocabulary->fingerprint_ = content.fingerprint;
  return vocabulary;
}

absl::StatusOr<std::shared_ptr<const Vocabulary>> Vocabulary::FromTree(VocabularyTree tree) {
  RETURN_IF_ERROR(ValidateStructure(VocabularyTreeView(tree)));
  RETURN_IF_ERROR(ValidateWeights(VocabularyTreeView(tree)));
  std::shared_ptr<Vocabulary> vocabulary(new Vocabulary(std::move(tree), nullptr));
  vocabulary->view_ = VocabularyTreeView(vocabulary->tree_);
  vocabulary->words_ = CountWords(vocabulary->view_);
  vocabulary->fingerprint_ = ComputeFingerprint(vocabulary->view_);
  return vocabulary;
}

Words Vocabulary::Transform(absl::Span<const Descriptor> descriptors) const {
  std::vector<TreePath> paths(descriptors.size());
  DescendTree(view_, descriptors, absl::MakeSpan(paths));
  return {MakeBag(view_, paths), MakeDirectIndex(paths)};
}

absl::Status Vocabulary::Verify() const {
  const std::string name = file_ ? file_->path() : "vocabulary";
  const uint64_t computed = ComputeFingerprint(view_);
  if (computed != fingerprint_) {
    return absl::DataLossError(absl::StrCat(name, ": checksum is ", absl::Hex(computed), ", not ",
                                            absl::Hex(fingerprint_), " as the header says"));
  }
  if (absl::Status status = ValidateWeights(view_); !status.ok()) {
    return absl::DataLossError(absl::StrCat(name, ": ", status.message()));
  }
  return absl::OkStatus();
}

double Similarity(const BagOfWords& a, const BagOfWords& b) {
  // 1 - |a - b| / 2 is the sum of the smaller weights where both sum to 1.
  double similarity = 0;
  for (size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i].word < b[j].word) {
      ++i;
    } else if (b[j].word < a[i].word) {
      ++j;
    } else {
      similarity += static_cast<double>(std::min(a[i++].weight, b[j++].weight));
    }
  }
  return similarity;
}

}  // namespace corbslam
