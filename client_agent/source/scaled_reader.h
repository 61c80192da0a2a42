// Scales the pictures of a sequence, for robots that can't work on all of their pixels.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_SCALED_READER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_SCALED_READER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "client_agent/source/frame_reader.h"

namespace corbslam::client_agent {

// Returns a reader whose pictures have `scale` (above 0, at most 1) of the sides, rounded to whole
// pixels, with the calibration that belongs to them. Depths are taken from the nearest pixel.
// INVALID_ARGUMENT where the pictures would have less than 64 pixels a side.
absl::StatusOr<std::unique_ptr<FrameReader>> ScaleReader(std::unique_ptr<FrameReader> reader,
                                                         double scale);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SCALED_READER_H_
