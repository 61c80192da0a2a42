// The inner loops over Hamming distances.
#ifndef CORBSLAM_SLAM_VOCABULARY_HAMMING_KERNELS_H_
#define CORBSLAM_SLAM_VOCABULARY_HAMMING_KERNELS_H_

#include <cstddef>
#include <cstdint>

#include "absl/types/span.h"
#include "slam/features/keypoint.h"
#include "slam/vocabulary/vocabulary_tree.h"

namespace corbslam {

// Does what DescendTree does.
void DescendTreeKernel(const VocabularyTreeView& tree, const Descriptor* descriptors, size_t count,
                       TreePath* paths);

// Writes for each of descriptors[indices[i]] the number of the nearest centre (the first among
// equals).
void AssignToNearest(const Descriptor* descriptors, absl::Span<const uint32_t> indices,
                     absl::Span<const Descriptor> centres, uint8_t* nearest);

// Sets distances[i] = min(distances[i], distance of descriptors[indices[i]] to `centre`).
void LowerDistances(const Descriptor* descriptors, absl::Span<const uint32_t> indices,
                    const Descriptor& centre, uint16_t* distances);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VOCABULARY_HAMMING_KERNELS_H_
