#include "slam/util/program_version.h"

namespace corbslam {

const char* CorbslamVersion() { return CORBSLAM_VERSION; }

}  // namespace corbslam
