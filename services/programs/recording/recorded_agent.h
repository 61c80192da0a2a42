// Makes an agent whose frames are recorded.
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDED_AGENT_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDED_AGENT_H_

#include <memory>

#include "client_agent/agent/agent.h"

namespace corbslam::services {

class FrameRecorder;

// The thread contract and effect are those of `agent`. Neither is owned; both outlive the result.
std::unique_ptr<client_agent::Agent> MakeRecordedAgent(client_agent::Agent* agent,
                                                       FrameRecorder* recorder);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDED_AGENT_H_
