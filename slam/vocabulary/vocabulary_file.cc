#include "slam/vocabulary/vocabulary_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kMagic[8] = {'C', 'O', 'R', 'B', 'V', 'O', 'C', '\n'};
constexpr uint32_t kVersion = 1;

struct Header {
  char magic[8];
  uint32_t version;
  uint32_t branching;
  uint32_t levels;
  uint32_t direct_level;
  uint32_t nodes;
  uint32_t words;
  uint64_t fingerprint;
  uint32_t reserved[6];
};
static_assert(sizeof(Header) == 64);

size_t FileSize(size_t nodes) {
  return sizeof(Header) + nodes * sizeof(Descriptor) + (nodes + 1) * sizeof(uint32_t) +
         nodes * sizeof(float);
}

uint32_t CountWords(const VocabularyTreeView& tree) {
  uint32_t words = 0;
  for (uint32_t node = 0; node < tree.nodes(); ++node) words += tree.IsLeaf(node);
  return words;
}

absl::Status Damaged(const MappedFile& file, absl::string_view fault) {
  return absl::DataLossError(absl::StrCat(file.path(), ": ", fault));
}

absl::Status CheckHeader(const Header& header, const MappedFile& file) {
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) {
    return Damaged(file, "is no vocabulary: wrong first bytes");
  }
  if (header.version != kVersion) {
    return Damaged(file, absl::StrCat("version is ", header.version, ", not ", kVersion));
  }
  if (header.nodes > kMaxVocabularyNodes || file.size() != FileSize(header.nodes)) {
    return Damaged(file, absl::StrCat("has ", file.size(), " bytes, not ", FileSize(header.nodes),
                                      " as its ", header.nodes, " nodes need"));
  }
  if (std::any_of(std::begin(header.reserved), std::end(header.reserved),
                  [](uint32_t value) { return value != 0; })) {
    return Damaged(file, "reserved bytes of the header are not 0");
  }
  return absl::OkStatus();
}

template <typename T>
absl::Status WriteArray(AtomicFile& file, const std::vector<T>& values) {
  return file.Append({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

}  // namespace

MappedFile::MappedFile(std::string path, const std::byte* data, size_t size)
    : path_(std::move(path)), data_(data), size_(size) {}

MappedFile::~MappedFile() {
  if (size_ > 0) munmap(const_cast<std::byte*>(data_), size_);
}

absl::StatusOr<std::unique_ptr<const MappedFile>> MappedFile::Open(const std::string& path) {
  const auto fail = [&path] {
    return absl::NotFoundError(absl::StrCat("cannot open ", path, ": ", std::strerror(errno)));
  };
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return fail();
  struct stat attributes = {};
  if (fstat(descriptor, &attributes) != 0 || !S_ISREG(attributes.st_mode)) {
    close(descriptor);
    return absl::NotFoundError(absl::StrCat("cannot open ", path, ": no regular file"));
  }
  const size_t size = static_cast<size_t>(attributes.st_size);
  void* data = nullptr;
  if (size > 0) data = mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0);
  close(descriptor);
  if (data == MAP_FAILED) return fail();
  return std::unique_ptr<const MappedFile>(
      new MappedFile(path, static_cast<const std::byte*>(data), size));
}

absl::StatusOr<VocabularyFileContent> ParseVocabulary(const MappedFile& file) {
  if (file.size() < sizeof(Header)) {
    return Damaged(file, absl::StrCat("has ", file.size(), " bytes, fewer than the header's ",
                                      sizeof(Header)));
  }
  Header header;
  std::memcpy(&header, file.data(), sizeof(header));
  RETURN_IF_ERROR(CheckHeader(header, file));

  // The mapping starts at a page and all sizes are multiples of 4: everything is aligned.
  const std::byte* const descriptors = file.data() + sizeof(Header);
  const std::byte* const children = descriptors + header.nodes * sizeof(Descriptor);
  const std::byte* const weights = children + (header.nodes + size_t{1}) * sizeof(uint32_t);
  VocabularyFileContent content;
  content.words = header.words;
  content.fingerprint = header.fingerprint;
  content.tree.branching = header.branching;
  content.tree.levels = header.levels;
  content.tree.direct_level = header.direct_level;
  content.tree.descriptors = {reinterpret_cast<const Descriptor*>(descriptors), header.nodes};
  content.tree.first_child = {reinterpret_cast<const uint32_t*>(children),
                              header.nodes + size_t{1}};
  content.tree.weights = {reinterpret_cast<const float*>(weights), header.nodes};
  if (absl::Status status = ValidateStructure(content.tree); !status.ok()) {
    return Damaged(file, status.message());
  }
  if (const uint32_t words = CountWords(content.tree); words != header.words) {
    return Damaged(file, absl::StrCat("has ", words, " words, not ", header.words));
  }
  return content;
}

absl::Status WriteVocabulary(const VocabularyTree& tree, const std::string& path) {
  const VocabularyTreeView view(tree);
  RETURN_IF_ERROR(ValidateStructure(view));
  RETURN_IF_ERROR(ValidateWeights(view));
  Header header = {};
  std::copy(std::begin(kMagic), std::end(kMagic), header.magic);
  header.version = kVersion;
  header.branching = tree.branching;
  header.levels = tree.levels;
  header.direct_level = tree.direct_level;
  header.nodes = view.nodes();
  header.words = CountWords(view);
  header.fingerprint = ComputeFingerprint(view);

  // The file is renamed when it is complete: a process that has the old one mapped keeps it.
  ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path, AtomicFile::Old::kReplaced,
                                                       AtomicFile::Readers::kOthersToo));
  RETURN_IF_ERROR(file.Append({reinterpret_cast<const char*>(&header), sizeof(header)}));
  RETURN_IF_ERROR(WriteArray(file, tree.descriptors));
  RETURN_IF_ERROR(WriteArray(file, tree.first_child));
  RETURN_IF_ERROR(WriteArray(file, tree.weights));
  return file.FinishUnsynced();
}

absl::StatusOr<VocabularySummary> InspectVocabulary(const std::string& path) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const Vocabulary> vocabulary, Vocabulary::Load(path));
  RETURN_IF_ERROR(vocabulary->Verify());
  const VocabularyTreeView& tree = vocabulary->tree();
  VocabularySummary summary;
  summary.branching = tree.branching;
  summary.levels = tree.levels;
  summary.direct_level = tree.direct_level;
  summary.nodes = tree.nodes();
  summary.words = vocabulary->words();
  summary.bytes = FileSize(tree.nodes());
  summary.fingerprint = vocabulary->fingerprint();
  summary.min_weight = std::numeric_limits<float>::infinity();
  double sum = 0;
  std::vector<uint32_t> depth(tree.nodes(), 0);
  for (uint32_t node = 0; node < tree.nodes(); ++node) {
    std::fill(depth.begin() + tree.first_child[node], depth.begin() + tree.first_child[node + 1],
              depth[node] + 1);
    const bool is_leaf = tree.IsLeaf(node);
    summary.direct_nodes +=
        depth[node] == tree.direct_level || (is_leaf && depth[node] < tree.direct_level);
    if (!is_leaf) continue;
    summary.min_weight = std::min(summary.min_weight, tree.weights[node]);
    summary.max_weight = std::max(summary.max_weight, tree.weights[node]);
    sum += static_cast<double>(tree.weights[node]);
  }
  summary.mean_weight = static_cast<float>(sum / static_cast<double>(summary.words));
  return summary;
}

}  // namespace corbslam
