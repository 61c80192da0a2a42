// Writes a simulated sequence as one of the public layouts, with calibration and ground truth.
#ifndef CORBSLAM_SERVICES_TOOL_SEQUENCE_SEQUENCE_WRITER_H_
#define CORBSLAM_SERVICES_TOOL_SEQUENCE_SEQUENCE_WRITER_H_

#include <cstddef>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::services {

struct WriteSequenceOptions {
  // kKitti: image_0, image_1, calib.txt, times.txt, poses.txt.
  // kEuroc: mav0/cam0 and cam1, mav0/state_groundtruth_estimate0; the body's frame is the left
  //   camera's.
  // kTum: rgb, depth, associated.txt, groundtruth.txt, calibration.yaml.
  client_agent::SourceLayout layout = client_agent::SourceLayout::kKitti;
  std::string folder;  // The folder is made; files that are there are written over.
  int threads = 1;     // Number of frames drawn and encoded at a time. It changes speed only.
  // Called with the number of frames done and of all frames, from any of the threads, one at a
  // time.
  std::function<void(size_t, size_t)> on_progress;
};

// Writes the frames and returns their number. Where `source` names no rig, the layout's own is
// taken; where it names a rig file, that is beside the pictures as rig.yaml. The same source gives
// the same bytes. INVALID_ARGUMENT for a source that is no simulation, is played backwards, or
// whose cameras the layout has no place for; UNAVAILABLE, naming the file, where writing fails.
absl::StatusOr<size_t> WriteSequence(const client_agent::SourceSpec& source,
                                     const WriteSequenceOptions& options);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_SEQUENCE_SEQUENCE_WRITER_H_
