// Says where the built page is.
#ifndef CORBSLAM_SERVICES_VIEWER_PAGE_PATH_H_
#define CORBSLAM_SERVICES_VIEWER_PAGE_PATH_H_

#include <string>

namespace corbslam::services {

// Returns the folder of the built page: $CORBSLAM_VIEWER_PAGE, or beside the installed program, or
// that of the build.
std::string DefaultPagePath();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_PAGE_PATH_H_
