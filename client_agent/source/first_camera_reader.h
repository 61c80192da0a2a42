// Plays the first camera of a pair, or the pictures of an RGB-D camera, alone.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_FIRST_CAMERA_READER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_FIRST_CAMERA_READER_H_

#include <memory>

#include "client_agent/source/frame_reader.h"

namespace corbslam::client_agent {

// Returns a reader of the same frames without their second pictures. One of one camera alone is
// returned as it is.
std::unique_ptr<FrameReader> FirstCameraAlone(std::unique_ptr<FrameReader> reader);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_FIRST_CAMERA_READER_H_
