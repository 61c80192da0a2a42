// Plays a recording without its IMU.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_WITHOUT_IMU_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_WITHOUT_IMU_H_

#include <memory>
#include <string>

#include "client_agent/source/frame_reader.h"

namespace corbslam::client_agent {

// Returns a reader of the same frames without what the IMU measured; its description says `why`. A
// reader that has no IMU is returned as it is.
std::unique_ptr<FrameReader> WithoutImu(std::unique_ptr<FrameReader> reader,
                                        const std::string& why);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_WITHOUT_IMU_H_
