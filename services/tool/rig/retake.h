// Takes a recording again through other cameras, for tests and measurements of lenses.
#ifndef CORBSLAM_SERVICES_TOOL_RIG_RETAKE_H_
#define CORBSLAM_SERVICES_TOOL_RIG_RETAKE_H_

#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::services {

// Writes the frames that `spec` selects of a rectified stereo recording as a pair of other cameras
// with the same centres would have taken them: DIR/image_0, image_1, times.txt and rig.yaml, to be
// played as "kitti:DIR?rig=DIR/rig.yaml". What the recording doesn't show is black. Returns the
// number of frames. INVALID_ARGUMENT where the recording is no rectified pair, the rig is one, or
// their baselines differ by more than a hundredth; UNAVAILABLE names a file that can't be written.
absl::StatusOr<size_t> Retake(const client_agent::FrameReader& reader,
                              const client_agent::SourceSpec& spec, const client_agent::Rig& rig,
                              const std::string& folder);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RIG_RETAKE_H_
