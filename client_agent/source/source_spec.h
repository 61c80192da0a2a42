// How a recorded sequence is named: "LAYOUT:DIR?OPTIONS", for example
// "kitti:DIR?frames=0:120&stride=2&offset=1&gamma=0.8&noise=4".
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_SPEC_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_SPEC_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam {

enum class SourceLayout {
  kKitti,  // KITTI odometry: image_0, image_1, calib.txt, times.txt.
  kEuroc,  // ASL: mav0/cam0, mav0/cam1 (or cam0, cam1 directly).
  kTum,    // TUM RGB-D: associated.txt, or rgb.txt and depth.txt.
};

// Which frames of a sequence, and in which order.
struct FrameSelection {
  size_t first = 0;            // frames=first:last, both included.
  std::optional<size_t> last;  // Absent: to the end.
  // Of these, the ones whose number in the sequence leaves `offset` when divided by `stride`.
  size_t stride = 1;
  size_t offset = 0;
  // From the last to the first. Timestamps stay the sequence's own, so they fall.
  bool reverse = false;
};

// Numbers of the selected frames, in the order in which they are played.
std::vector<size_t> SelectFrames(const FrameSelection& selection, size_t frame_count);

// What is done to the pictures; the same for the same seed and frame.
struct Perturbation {
  double gamma = 1.0;        // grey' = 255 (grey / 255)^gamma.
  double noise_sigma = 0.0;  // Normally distributed, in grey levels.
  uint64_t seed = 1;
};

struct SourceSpec {
  SourceLayout layout = SourceLayout::kKitti;
  std::string directory;
  FrameSelection selection;
  Perturbation perturbation;
};

// INVALID_ARGUMENT, naming the option and its value.
absl::StatusOr<SourceSpec> ParseSourceSpec(absl::string_view text);
// Parses back to the same.
std::string FormatSourceSpec(const SourceSpec& spec);

// Applies "gamma=0.8,noise=4,reverse" or one with '&' between to a spec; what the options of a
// spec are made of.
absl::Status ApplyOptions(absl::string_view options, SourceSpec& spec);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_SPEC_H_
