// The page's template and style, as they were when the program was built.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_PAGE_PARTS_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_PAGE_PARTS_H_

#include "absl/strings/string_view.h"

namespace corbslam::services {

// Parts in double braces, as {{title}}, are replaced.
absl::string_view PageTemplate();
absl::string_view PageStyle();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_PAGE_PARTS_H_
