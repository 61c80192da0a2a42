// Says in words that what others mapped contradicts what the robot sees.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_OTHERS_WORDS_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_OTHERS_WORDS_H_

#include "client_agent/source/source_finding.h"
#include "client_agent/tracking/others_trust.h"

namespace corbslam::client_agent {

// Returns a warning "others-contradict", or one "others-fit-again" where the contradiction ended.
SourceFinding DescribeOthers(const OthersNews& news);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_OTHERS_WORDS_H_
