// Describes for people what a robot finds wrong in what others made.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_CONTRADICTION_TEXT_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_CONTRADICTION_TEXT_H_

#include "client_agent/source/source_finding.h"
#include "slam/exchange/agent_report.h"

namespace corbslam::client_agent {

SourceFinding DescribeContradiction(const MapContradiction& found);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_CONTRADICTION_TEXT_H_
