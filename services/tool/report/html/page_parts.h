// The page's template, style and script, as they were when the program was built.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_PAGE_PARTS_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_PAGE_PARTS_H_

#include "absl/strings/string_view.h"

namespace corbslam::services {

// Parts in double braces, as {{title}}, are replaced.
absl::string_view PageTemplate();
absl::string_view PageStyle();
absl::string_view PageScript();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_PAGE_PARTS_H_
