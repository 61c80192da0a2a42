// Writes a simulated sequence as one of the public layouts, with calibration and ground truth.
#ifndef CORBSLAM_SERVICES_TOOL_SEQUENCE_SEQUENCE_WRITER_H_
#define CORBSLAM_SERVICES_TOOL_SEQUENCE_SEQUENCE_WRITER_H_

#include <cstddef>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/source_spec.h"

namespace corbslam {

struct WriteSequenceOptions {
  // kKitti: image_0, image_1, calib.txt, times.txt, poses.txt.
  // kEuroc: mav0/cam0 and cam1, mav0/state_groundtruth_estimate0; the body's frame is the left
  //   camera's.
  // kTum: rgb, depth, associated.txt, groundtruth.txt, calibration.yaml.
  SourceLayout layout = SourceLayout::kKitti;
  std::string folder;  // Made; files that are there are written over.
  int threads = 1;     // Frames drawn and encoded at a time. Changes speed only.
  // Frames done and in all; called from any of the threads, one at a time.
  std::function<void(size_t, size_t)> on_progress;
};

// Where `source` names no rig, the layout's own is taken. The same source gives the same bytes.
// Returns the frames written. INVALID_ARGUMENT for a source that is no simulation, is played
// backwards, or whose cameras the layout has no place for; UNAVAILABLE, naming the file, where
// writing fails.
absl::StatusOr<size_t> WriteSequence(const SourceSpec& source, const WriteSequenceOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_SEQUENCE_SEQUENCE_WRITER_H_
