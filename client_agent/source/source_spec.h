// How a sequence is named: "LAYOUT:DIR?OPTIONS", for example
// "kitti:DIR?frames=0:120&stride=2&offset=1&gamma=0.8&noise=4"; or, of a kind that the program has
// registered (source_kinds.h), "KIND:PLACE?OPTIONS".
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_SPEC_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_SPEC_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/source_kinds.h"

namespace corbslam {

enum class SourceLayout {
  kKitti,        // KITTI odometry: image_0, image_1, calib.txt, times.txt.
  kEuroc,        // ASL: mav0/cam0, mav0/cam1 (or cam0, cam1 directly).
  kTum,          // TUM RGB-D: associated.txt, or rgb.txt and depth.txt.
  kSevenScenes,  // 7-Scenes: frame-000000.color.png and frame-000000.depth.png.
  kRegistered,   // None of them: of a registered kind, as SourceSpec::settings say.
};

// A robot's part of a sequence that several share, in the order in which it was driven.
struct SequencePart {
  size_t robot = 1;  // From 1 on.
  size_t robots = 1;
  // Frames by which a part reaches beyond its share, on each side where there is another.
  size_t overlap = 20;
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
  // robot=2/3, overlap=20: only this part of the frames between first and last.
  std::optional<SequencePart> part;
};

// Frames [begin, end) as they are shared: part k of n, k from 0 on, is
// [begin + floor(k t / n) - overlap, begin + ceil((k + 1) t / n) + overlap), within [begin, end).
// For two robots and t frames: [0, t/2 + d] and [t/2 - d, t] (CORB-SLAM, section 4). An empty range
// stays empty.
struct FrameRange {
  size_t begin = 0;
  size_t end = 0;
};
FrameRange TakePart(const FrameRange& frames, const SequencePart& part);

// What lies between first and last of `frame_count` frames, and of that the part.
FrameRange SelectRange(const FrameSelection& selection, size_t frame_count);

// Numbers of the selected frames, in the order in which they are played.
std::vector<size_t> SelectFrames(const FrameSelection& selection, size_t frame_count);

// What is done to the pictures; the same for the same seed and frame.
struct Perturbation {
  double gamma = 1.0;        // grey' = 255 (grey / 255)^gamma.
  double noise_sigma = 0.0;  // Normally distributed, in grey levels.
  uint64_t seed = 1;
};

// What a recording's own files leave open, or say wrongly.
struct SourceOpening {
  // camera=NAME, RGB-D: the calibration that was published for this camera (named_cameras.h).
  std::string camera;
  // calibration=FILE, RGB-D: instead of the one in the recording's folder.
  std::string calibration_file;
  // trust-calibration: also an improbable one is taken.
  bool trust_calibration = false;
  // fps=RATE: pictures that have no times were taken at this rate, the first at 0 s.
  std::optional<double> fps;
  // images=grey or images=colour, KITTI: which of its two pairs of cameras. Empty: grey where
  // there.
  std::string images;
  // pair-within-ms=T, EuRoC: how far the times of a pair's two pictures may be apart.
  double pair_within_ms = 2;
};

struct SourceSpec {
  SourceLayout layout = SourceLayout::kKitti;
  std::string directory;        // Of kRegistered what the kind calls its place.
  SharedKindSettings settings;  // kRegistered only; else null.
  SourceOpening opening;        // Recorded sequences only.
  FrameSelection selection;
  Perturbation perturbation;
  // truth_frame=NAME, of recorded sequences: those with the same name have their ground truth in
  // one frame. Empty: in none but their own.
  std::string truth_frame;
};

// Numbers of the selected frames in the sequence itself, in the order in which they are played. For
// a way that is driven the other way round, the selection counts frames as if it weren't: it means
// the same places.
std::vector<size_t> FramesOf(const SourceSpec& spec, size_t frame_count);

// "kitti" and so on, without the registered kinds.
std::vector<absl::string_view> RecordedLayoutNames();

// A folder whose name holds '?' is recognised where it exists; names of options may be written with
// '-' or '_'. INVALID_ARGUMENT, naming the option and its value.
absl::StatusOr<SourceSpec> ParseSourceSpec(absl::string_view text);
// Parses back to the same.
std::string FormatSourceSpec(const SourceSpec& spec);

// Applies "gamma=0.8,noise=4,reverse" or one with '&' between to a spec; what the options of a
// spec are made of.
absl::Status ApplyOptions(absl::string_view options, SourceSpec& spec);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_SPEC_H_
