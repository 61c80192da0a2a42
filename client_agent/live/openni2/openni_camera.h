// Plays a device of OpenNI 2 as a live camera.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_CAMERA_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_CAMERA_H_

#include <memory>
#include <optional>

#include "client_agent/live/live_stream.h"
#include "client_agent/live/openni2/openni_device.h"

namespace corbslam::client_agent {

// Plays `device`, which `options` opened. Times are the device's own, from the time on at which its
// first picture came. Where the device is unplugged or fails it is opened again each second, unless
// `restarts` is false; a recording's end is the stream's, unless it is true.
std::unique_ptr<LiveCamera> MakeOpenNiCamera(std::unique_ptr<OpenNiDevice> device,
                                             const OpenNiOptions& options,
                                             std::optional<bool> restarts);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_CAMERA_H_
