#include "services/agent_service/mask_png.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

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
  // OpenCV reads from the bytes alone. It throws for pictures beyond its limits.
  const cv::Mat bytes(1, static_cast<int>(png.size()), CV_8UC1, const_cast<char*>(png.data()));
  cv::Mat mask;
  try {
    mask = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("png can't be decoded: ", error.err));
  }
  if (mask.empty()) return absl::InvalidArgumentError("png can't be decoded");
  return mask;
}

}  // namespace corbslam::services
