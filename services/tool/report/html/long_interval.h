// Says from which time between two frames on something was lost there.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_LONG_INTERVAL_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_LONG_INTERVAL_H_

#include <vector>

namespace corbslam::services {

// Returns three times the median of the intervals between frames, in seconds; 0 without any.
double LongInterval_s(std::vector<double> intervals_s);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_LONG_INTERVAL_H_
