// Learns a vocabulary tree: hierarchical k-majority (Grana et al., 2013) with k-means++ seeds
// (Arthur and Vassilvitskii, SODA 2007), weights by inverse document frequency.
#ifndef CORBSLAM_SLAM_VOCABULARY_TRAINER_H_
#define CORBSLAM_SLAM_VOCABULARY_TRAINER_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/features/keypoint.h"
#include "slam/features/orb_extractor.h"
#include "slam/vocabulary/vocabulary_tree.h"

namespace corbslam {

struct TrainingOptions {
  int branching = 10;
  int levels = 5;
  // Depth of the direct index's nodes.
  int direct_level = 2;
  // Iterations of each clustering; it ends sooner when nothing changes.
  int max_iterations = 12;
  // Nodes with fewer descriptors become words.
  int min_descriptors_to_split = 2;
  uint64_t seed = 1;
  // Bounds the memory: of more descriptors, evenly spaced ones are used for clustering (all of them
  // for the weights).
  size_t max_descriptors = 4'000'000;
  // Changes speed only; the result is the same.
  int threads = 2;

  // INVALID_ARGUMENT names the field, its value and its limits.
  absl::Status Validate() const;
};

// One vector of descriptors a picture.
using PictureDescriptors = std::vector<std::vector<Descriptor>>;
// It is called from the caller's thread and told what is going on, and how much of it is done.
using TrainingProgress = std::function<void(const std::string& step, size_t done, size_t total)>;

// Trains on the descriptors. The result depends on the options (but not threads) and descriptors
// alone. INVALID_ARGUMENT without descriptors.
absl::StatusOr<VocabularyTree> TrainVocabulary(const TrainingOptions& options,
                                               const PictureDescriptors& pictures,
                                               const TrainingProgress& progress = nullptr);

// Extracts features of the image files and trains on them, in the order of `paths`.
// INVALID_ARGUMENT names a file that is no image.
absl::StatusOr<VocabularyTree> TrainFromPictures(const std::vector<std::string>& paths,
                                                 const OrbOptions& orb,
                                                 const TrainingOptions& options,
                                                 const TrainingProgress& progress = nullptr);
// Only extracts the features, as TrainFromPictures does first.
absl::StatusOr<PictureDescriptors> ExtractDescriptors(const std::vector<std::string>& paths,
                                                      const OrbOptions& orb,
                                                      const TrainingProgress& progress = nullptr);
// Returns the image files (png, jpg, jpeg, pgm) directly in a folder, sorted. NOT_FOUND if there is
// none.
absl::StatusOr<std::vector<std::string>> ListPictures(const std::string& folder);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VOCABULARY_TRAINER_H_
