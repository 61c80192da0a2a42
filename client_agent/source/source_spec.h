// Says how a sequence is named: "LAYOUT:DIR?OPTIONS", for example
// "kitti:DIR?frames=0:120&stride=2&offset=1&gamma=0.8&noise=4"; or, for a kind that the program has
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
#include "client_agent/source/frame_selection.h"
#include "client_agent/source/source_kinds.h"

namespace corbslam::client_agent {

enum class SourceLayout {
  kKitti,        // KITTI odometry: image_0, image_1, calib.txt, times.txt.
  kEuroc,        // ASL: mav0/cam0, mav0/cam1 (or cam0, cam1 directly).
  kTum,          // TUM RGB-D: associated.txt, or rgb.txt and depth.txt.
  kSevenScenes,  // 7-Scenes: frame-000000.color.png and frame-000000.depth.png.
  kRegistered,   // None of these layouts, but the kind of SourceSpec::settings.
};

// Says what is done to the pictures, which is the same for the same seed and frame.
struct Perturbation {
  double gamma = 1.0;        // grey' = 255 (grey / 255)^gamma.
  double noise_sigma = 0.0;  // Standard deviation of normal noise, in grey levels.
  uint64_t seed = 1;
};

// Says what a recording's own files leave open, or say wrongly.
struct SourceOpening {
  // rig=FILE: the rig file whose cameras recorded the pictures (rig/rig.h), instead of what the
  // recording's own files say. Empty: none.
  std::string rig_file;
  // scale=S: pictures are scaled by this before anything else sees them, 0.1 to 1.
  double scale = 1;
  // camera=NAME, RGB-D: the calibration that was published for this camera (named_cameras.h).
  std::string camera;
  // calibration=FILE, RGB-D: the file to take instead of the one in the recording's folder.
  std::string calibration_file;
  // register=1, RGB-D with a rig: depth is registered to the pictures; register=0: it is already.
  // Nullopt: as the rig says.
  std::optional<bool> registers;
  // trust-calibration: also an improbable calibration is taken.
  bool trust_calibration = false;
  // fps=RATE: pictures that have no times were taken at this rate, the first at 0 s.
  std::optional<double> fps;
  // images=grey or images=colour, KITTI: which of its two pairs of cameras is taken. Empty: grey
  // where that is there.
  std::string images;
  // pair-within-ms=T, EuRoC: how far the times of a pair's two pictures may be apart.
  double pair_within_ms = 2;
  // imu=FILE: what the IMU measured, in EuRoC's form, instead of the recording's own list. "0": it
  // is played without. Empty: the recording's own list, where it has one.
  std::string imu;
};

struct SourceSpec {
  SourceLayout layout = SourceLayout::kKitti;
  std::string directory;        // For kRegistered what the kind calls its place.
  SharedKindSettings settings;  // Set for kRegistered only; else null.
  SourceOpening opening;        // Used for recorded sequences only.
  FrameSelection selection;
  Perturbation perturbation;
  // truth_frame=NAME, of recorded sequences: those with the same name have their ground truth in
  // one frame. Empty: it is in no frame but their own.
  std::string truth_frame;
  // cameras=1: of a pair or an RGB-D camera the first camera is played alone.
  bool one_camera = false;
};

// Returns the numbers of the selected frames in the sequence itself, in the order in which they are
// played. For a way that is driven the other way round, the selection counts frames as if it
// weren't: it means the same places.
std::vector<size_t> FramesOf(const SourceSpec& spec, size_t frame_count);

// Returns "kitti" and so on, without the registered kinds.
std::vector<absl::string_view> RecordedLayoutNames();

// Parses a spec. In options' values %26, %2C and %25 are '&', ',' and '%', as in URLs. A folder
// whose name holds '?' is recognised where it exists; names of options may be written with '-' or
// '_'. Returns INVALID_ARGUMENT, naming the option and its value.
absl::StatusOr<SourceSpec> ParseSourceSpec(absl::string_view text);
// Writes a spec that parses back to the same.
std::string FormatSourceSpec(const SourceSpec& spec);

// Applies "gamma=0.8,noise=4,reverse", or the same with '&' in between, to a spec. The options of a
// spec have this form.
absl::Status ApplyOptions(absl::string_view options, SourceSpec& spec);

// Does what the option rig=PATH does. INVALID_ARGUMENT where the source takes no rig.
absl::Status UseRig(const std::string& path, SourceSpec& spec);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_SPEC_H_
