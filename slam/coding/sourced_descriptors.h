// Descriptors most of which are copies of others that the reader has: map points look as one of
// the keypoints does that see them.
#ifndef CORBSLAM_SLAM_CODING_SOURCED_DESCRIPTORS_H_
#define CORBSLAM_SLAM_CODING_SOURCED_DESCRIPTORS_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/features/keypoint.h"

namespace corbslam {

// Version of the format; a change of a model or of its weights needs another one.
inline constexpr uint8_t kSourcedDescriptorsVersion = 1;

// What the reader has that descriptor i may be a copy of; empty: nothing.
using DescriptorSources = std::span<const std::span<const Descriptor>>;

// Takes as many sources as descriptors.
std::string EncodeSourced(std::span<const Descriptor> descriptors, DescriptorSources sources);

// Returns one descriptor a source; the sources must be those that were written with.
// INVALID_ARGUMENT names what is wrong. Time and memory are in proportion to the number of sources.
absl::StatusOr<std::vector<Descriptor>> DecodeSourced(std::string_view bytes,
                                                      DescriptorSources sources);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_SOURCED_DESCRIPTORS_H_
