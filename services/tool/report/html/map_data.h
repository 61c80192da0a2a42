// The map as the page's script reads it.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_MAP_DATA_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_MAP_DATA_H_

#include <cstddef>
#include <string>
#include <vector>

#include "services/tool/report/html/report_page.h"
#include "slam/rendering/paint.h"

namespace corbslam::services {

// Of more points, every so-manyth is told.
inline constexpr size_t kMostMapPoints = 60'000;

// Returns JSON without "<", for a script element; "null" of a map without keyframes. Its frame has
// z upwards and the longest motion along x. Points are numbers of 16 bits in a box that leaves out
// what lies far from everything; poses and paths are floats, little-endian, in base64.
std::string WriteMapData(const ReportDetail& detail);

// Returns a colour for each robot of the report, by its index: the own one has the first.
std::vector<Paint> RobotPaints(const ReportDetail& detail);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_MAP_DATA_H_
