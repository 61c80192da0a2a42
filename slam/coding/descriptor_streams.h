// Descriptors to arithmetic-coded bytes and back, by the model of descriptor_model.h.
#ifndef CORBSLAM_SLAM_CODING_DESCRIPTOR_STREAMS_H_
#define CORBSLAM_SLAM_CODING_DESCRIPTOR_STREAMS_H_

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "slam/features/keypoint.h"

namespace corbslam {

// Descriptor i is in stream i mod 4: four that don't wait for each other keep a processor busy.
inline constexpr size_t kDescriptorStreams = 4;

std::array<std::string, kDescriptorStreams> EncodeDescriptors(
    std::span<const Descriptor> descriptors);

// Fills `descriptors`. Returns false when the streams are not those of as many descriptors. It
// can't notice every damage: a caller that must know keeps a checksum beside the streams.
bool DecodeDescriptors(const std::array<std::string_view, kDescriptorStreams>& streams,
                       std::span<Descriptor> descriptors);

// Do the same without instructions that not every processor has. The results are equal.
std::array<std::string, kDescriptorStreams> EncodeDescriptorsPortably(
    std::span<const Descriptor> descriptors);
bool DecodeDescriptorsPortably(const std::array<std::string_view, kDescriptorStreams>& streams,
                               std::span<Descriptor> descriptors);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_DESCRIPTOR_STREAMS_H_
