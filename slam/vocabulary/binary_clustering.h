// Splits binary descriptors into clusters: k-majority (Grana et al., 2013), seeded as k-means++
// (Arthur and Vassilvitskii, SODA 2007).
#ifndef CORBSLAM_SLAM_VOCABULARY_BINARY_CLUSTERING_H_
#define CORBSLAM_SLAM_VOCABULARY_BINARY_CLUSTERING_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "slam/features/keypoint.h"

namespace corbslam {

struct BinaryClusters {
  // No two are equal.
  std::vector<Descriptor> centres;
  // sizes[c] of the indices belong to centre c; they are sorted by centre, and within one they stay
  // in order. Each is > 0.
  std::vector<uint32_t> sizes;
};

// Finds at most `count` (up to 255) clusters of descriptors[indices[..]], whose indices it
// reorders. Every index ends with the centre nearest to it, the first among equals. The result
// depends on the arguments alone.
BinaryClusters ClusterDescriptors(absl::Span<const Descriptor> descriptors,
                                  absl::Span<uint32_t> indices, int count, int max_iterations,
                                  uint64_t seed);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VOCABULARY_BINARY_CLUSTERING_H_
