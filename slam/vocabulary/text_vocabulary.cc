// Implements ReadTextVocabulary and WriteTextVocabulary.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "slam/vocabulary/vocabulary_file.h"

namespace corbslam {
namespace {

struct TextNode {
  uint32_t parent = 0;
  bool is_leaf = false;
  Descriptor descriptor;
  float weight = 0;
};

// Takes fields off the front of a line.
class FieldReader {
 public:
  explicit FieldReader(absl::string_view line) : rest_(line) {}

  // Returns the next field, which is empty at the end of the line.
  absl::string_view Next() {
    const size_t begin = rest_.find_first_not_of(" \t\r");
    if (begin == absl::string_view::npos) return rest_ = {};
    rest_.remove_prefix(begin);
    const absl::string_view field = rest_.substr(0, rest_.find_first_of(" \t\r"));
    rest_.remove_prefix(field.size());
    return field;
  }
  bool NextInteger(uint32_t limit, uint32_t& value) {
    const absl::string_view field = Next();
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    return error == std::errc() && end == field.data() + field.size() && !field.empty() &&
           value <= limit;
  }

 private:
  absl::string_view rest_;
};

absl::StatusOr<TextNode> ParseNode(absl::string_view text, uint32_t number, const std::string& path,
                                   int line) {
  FieldReader fields(text);
  TextNode node;
  uint32_t is_leaf = 0;
  if (!fields.NextInteger(number - 1, node.parent)) {
    return LineError(path, line, absl::StrCat("parent is no node before ", number));
  }
  if (!fields.NextInteger(1, is_leaf)) return LineError(path, line, "is_leaf is not 0 or 1");
  node.is_leaf = is_leaf == 1;
  for (size_t i = 0; i < 32; ++i) {
    uint32_t byte = 0;
    if (!fields.NextInteger(255, byte)) {
      return LineError(path, line, absl::StrCat("byte ", i, " of 32 is not 0 to 255"));
    }
    node.descriptor.words[i / 8] |= uint64_t{byte} << (8 * (i % 8));
  }
  if (!absl::SimpleAtof(fields.Next(), &node.weight) || !std::isfinite(node.weight) ||
      node.weight < 0) {
    return LineError(path, line, "weight is no number of 0 or more");
  }
  if (!fields.Next().empty()) return LineError(path, line, "more fields than a node has");
  return node;
}

absl::Status ParseFirstLine(absl::string_view text, const std::string& path, int line,
                            VocabularyTree& tree) {
  FieldReader fields(text);
  uint32_t scoring = 0;
  uint32_t weighting = 0;
  if (!fields.NextInteger(kMaxBranching, tree.branching) || tree.branching < 2 ||
      !fields.NextInteger(kMaxLevels, tree.levels) || tree.levels < 1) {
    return LineError(path, line,
                     absl::StrCat("does not start with branching (2 to ", kMaxBranching,
                                  ") and levels (1 to ", kMaxLevels, ")"));
  }
  if (!fields.NextInteger(0, scoring) || !fields.NextInteger(0, weighting)) {
    return LineError(path, line, "scoring and weighting are not 0 (L1 and TF-IDF)");
  }
  if (!fields.Next().empty()) return LineError(path, line, "more fields than the first line has");
  return absl::OkStatus();
}

// Checks what only the whole file shows. lines[i] is where node i stands.
absl::Status CheckNodes(const std::vector<TextNode>& nodes, const std::vector<int>& lines,
                        const VocabularyTree& tree, const std::string& path) {
  std::vector<uint32_t> children(nodes.size(), 0);
  std::vector<uint32_t> depth(nodes.size(), 0);
  for (size_t i = 1; i < nodes.size(); ++i) {
    const uint32_t parent = nodes[i].parent;
    depth[i] = depth[parent] + 1;
    if (nodes[parent].is_leaf) {
      return LineError(path, lines[i], absl::StrCat("parent ", parent, " is a leaf"));
    }
    if (depth[i] > tree.levels) {
      return LineError(path, lines[i], absl::StrCat("deeper than ", tree.levels, " levels"));
    }
    if (++children[parent] > tree.branching) {
      return LineError(
          path, lines[i],
          absl::StrCat("parent ", parent, " has more than ", tree.branching, " children"));
    }
  }
  for (size_t i = 1; i < nodes.size(); ++i) {
    if (!nodes[i].is_leaf && children[i] == 0) {
      return LineError(path, lines[i], absl::StrCat("node ", i, " is no leaf without children"));
    }
  }
  return absl::OkStatus();
}

// Fills the tree breadth first, children in order of lines.
void FillTree(const std::vector<TextNode>& nodes, VocabularyTree& tree) {
  std::vector<uint32_t> begin(nodes.size() + 1, 0);
  for (size_t i = 1; i < nodes.size(); ++i) ++begin[nodes[i].parent + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<uint32_t> child(nodes.size() - 1);
  std::vector<uint32_t> next = begin;
  for (uint32_t i = 1; i < nodes.size(); ++i) child[next[nodes[i].parent]++] = i;

  std::vector<uint32_t> order = {0};
  std::vector<uint32_t> depth = {0};
  order.reserve(nodes.size());
  tree.levels = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    const uint32_t node = order[i];
    tree.first_child.push_back(static_cast<uint32_t>(order.size()));
    tree.descriptors.push_back(nodes[node].descriptor);
    tree.weights.push_back(nodes[node].is_leaf ? nodes[node].weight : 0.0f);
    tree.levels = depth[i];
    order.insert(order.end(), child.begin() + begin[node], child.begin() + begin[node + 1]);
    depth.resize(order.size(), depth[i] + 1);
  }
  tree.first_child.push_back(static_cast<uint32_t>(order.size()));
}

}  // namespace

absl::StatusOr<VocabularyTree> ReadTextVocabulary(const std::string& path) {
  VocabularyTree tree;
  std::vector<TextNode> nodes(1);
  std::vector<int> lines = {0};
  int last_line = 0;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    last_line = line;
    if (lines.front() == 0) {
      lines.front() = line;
      return ParseFirstLine(text, path, line, tree);
    }
    if (nodes.size() >= kMaxVocabularyNodes) return LineError(path, line, "too many nodes");
    ASSIGN_OR_RETURN(const TextNode node,
                     ParseNode(text, static_cast<uint32_t>(nodes.size()), path, line));
    nodes.push_back(node);
    lines.push_back(line);
    return absl::OkStatus();
  }));
  if (nodes.size() < 2) return LineError(path, last_line, "ends before the first node");
  RETURN_IF_ERROR(CheckNodes(nodes, lines, tree, path));
  FillTree(nodes, tree);
  tree.direct_level = tree.levels < 2 ? tree.levels : 2;
  RETURN_IF_ERROR(ValidateStructure(VocabularyTreeView(tree)));
  return tree;
}

absl::Status WriteTextVocabulary(const VocabularyTree& tree, const std::string& path) {
  const VocabularyTreeView view(tree);
  RETURN_IF_ERROR(ValidateStructure(view));
  std::vector<std::string> lines = {absl::StrCat(tree.branching, " ", tree.levels, " 0 0")};
  std::vector<uint32_t> parent(view.nodes(), 0);
  for (uint32_t node = 0; node < view.nodes(); ++node) {
    std::fill(parent.begin() + tree.first_child[node], parent.begin() + tree.first_child[node + 1],
              node);
    if (node == 0) continue;
    std::string line = absl::StrCat(parent[node], " ", view.IsLeaf(node) ? 1 : 0);
    for (size_t i = 0; i < 32; ++i) {
      absl::StrAppend(&line, " ", (tree.descriptors[node].words[i / 8] >> (8 * (i % 8))) & 0xff);
    }
    absl::StrAppendFormat(&line, " %.9g", tree.weights[node]);
    lines.push_back(std::move(line));
  }
  return WriteLines(lines, path);
}

}  // namespace corbslam
