// Turns a picture's descriptors into words (Galvez-Lopez and Tardos, T-RO 2012).
#ifndef CORBSLAM_SLAM_VOCABULARY_VOCABULARY_H_
#define CORBSLAM_SLAM_VOCABULARY_VOCABULARY_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "slam/features/keypoint.h"
#include "slam/vocabulary/vocabulary_tree.h"
#include "slam/vocabulary/words.h"

namespace corbslam {

class MappedFile;

// Immutable; safe to use from any thread.
class Vocabulary {
 public:
  // Maps a file that WriteVocabulary made; it must not be changed while in use. Checks sizes and
  // the tree's structure, so that no content can make a look-up leave the file; Verify() checks
  // the rest. NOT_FOUND if it can't be opened, DATA_LOSS naming the fault if it is damaged.
  static absl::StatusOr<std::shared_ptr<const Vocabulary>> Load(const std::string& path);
  // INVALID_ARGUMENT if the tree is malformed.
  static absl::StatusOr<std::shared_ptr<const Vocabulary>> FromTree(VocabularyTree tree);

  Vocabulary(const Vocabulary&) = delete;
  Vocabulary& operator=(const Vocabulary&) = delete;
  ~Vocabulary();

  // Returns TF-IDF weights that sum to 1, and the direct index. Words of weight 0 (seen in every
  // training picture) are not in the bag; their features are in the direct index.
  Words Transform(absl::Span<const Descriptor> descriptors) const;

  // Reads the whole file: DATA_LOSS unless the content is what was written.
  absl::Status Verify() const;

  size_t nodes() const { return view_.nodes(); }
  size_t words() const { return words_; }
  int branching() const { return static_cast<int>(view_.branching); }
  int levels() const { return static_cast<int>(view_.levels); }
  // Returns the same number for the same vocabulary, wherever it was loaded from.
  uint64_t fingerprint() const { return fingerprint_; }
  const VocabularyTreeView& tree() const { return view_; }

 private:
  Vocabulary(VocabularyTree tree, std::unique_ptr<const MappedFile> file);

  // One of the two holds what view_ shows.
  const VocabularyTree tree_;
  const std::unique_ptr<const MappedFile> file_;
  VocabularyTreeView view_;
  size_t words_ = 0;
  uint64_t fingerprint_ = 0;
};

// Returns 1 for the same bag and 0 for bags that share no word, by equation 2 of Galvez-Lopez and
// Tardos 2012 for bags whose weights sum to 1.
double Similarity(const BagOfWords& a, const BagOfWords& b);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VOCABULARY_VOCABULARY_H_
