// Reads and writes files of vocabularies: our own binary form, to be mapped into memory, and
// ORB-SLAM2's text. The binary form is little endian: a header of 64 bytes, then the arrays of
// VocabularyTree in the order descriptors, first_child, weights.
#ifndef CORBSLAM_SLAM_VOCABULARY_VOCABULARY_FILE_H_
#define CORBSLAM_SLAM_VOCABULARY_VOCABULARY_FILE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/vocabulary/vocabulary_tree.h"

namespace corbslam {

// A file mapped for reading. It is immutable as long as nobody writes to the file.
class MappedFile {
 public:
  // NOT_FOUND names the path and the system's reason.
  static absl::StatusOr<std::unique_ptr<const MappedFile>> Open(const std::string& path);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  const std::byte* data() const { return data_; }
  size_t size() const { return size_; }
  const std::string& path() const { return path_; }

 private:
  MappedFile(std::string path, const std::byte* data, size_t size);

  const std::string path_;
  const std::byte* const data_;
  const size_t size_;
};

struct VocabularyFileContent {
  VocabularyTreeView tree;  // The view lives as long as the mapped file.
  uint32_t words = 0;
  uint64_t fingerprint = 0;  // The header's value, which is not compared with the content.
};
// DATA_LOSS names the path and the fault: magic, version, limits, size, structure.
absl::StatusOr<VocabularyFileContent> ParseVocabulary(const MappedFile& file);

// Replaces the file as a whole. UNAVAILABLE names the path; INVALID_ARGUMENT for a malformed tree.
absl::Status WriteVocabulary(const VocabularyTree& tree, const std::string& path);

// The text form that ORB-SLAM2 reads: "k L scoring weighting", then a line a node: the parent's
// number (nodes are numbered from 1 in order of lines, 0 is the root), 1 for a leaf or 0, 32
// bytes, weight. Scoring and weighting must be 0 (L1, TF-IDF). INVALID_ARGUMENT names file and
// line; NOT_FOUND if the file can't be opened.
absl::StatusOr<VocabularyTree> ReadTextVocabulary(const std::string& path);
absl::Status WriteTextVocabulary(const VocabularyTree& tree, const std::string& path);

struct VocabularySummary {
  uint32_t branching = 0;
  uint32_t levels = 0;
  uint32_t direct_level = 0;
  size_t nodes = 0;
  size_t words = 0;
  size_t direct_nodes = 0;  // Number of groups of the direct index.
  size_t bytes = 0;         // Size of the file.
  uint64_t fingerprint = 0;
  float min_weight = 0;
  float mean_weight = 0;
  float max_weight = 0;
};
// Reads and verifies the whole file; DATA_LOSS if it is damaged.
absl::StatusOr<VocabularySummary> InspectVocabulary(const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VOCABULARY_VOCABULARY_FILE_H_
