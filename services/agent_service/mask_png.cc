#include "services/agent_service/mask_png.h"

#include <glog/logging.h>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/pictures/mask_picture.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kMaxMaskBytes = 4 << 20;
constexpr absl::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);

}  // namespace

absl::StatusOr<PictureMask> DecodeMask(const std::string& png) {
  if (png.empty()) return PictureMask();
  if (png.size() > kMaxMaskBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("png has ", png.size(), " bytes, must have at most ", kMaxMaskBytes));
  }
  if (!absl::StartsWith(png, kPngSignature)) {
    return absl::InvalidArgumentError("png does not begin as a PNG does");
  }
  ASSIGN_OR_RETURN(PictureMask mask, client_agent::DecodeMaskPicture("png", png));
  const double percent = client_agent::MaskedPercent(mask);
  LOG_IF(WARNING, percent > client_agent::kWideMask_percent)
      << "a mask that was set leaves out " << percent << " % of the picture: is it inverted?";
  return mask;
}

}  // namespace corbslam::services
