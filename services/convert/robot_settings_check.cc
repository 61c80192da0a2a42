#include "services/convert/robot_settings_check.h"

#include <algorithm>
#include <array>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "services/convert/limits.h"
#include "services/convert/resource_names.h"
#include "slam/features/feature_limits.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr double kLeastRate_hz = 0.1;
constexpr double kMostRate_hz = 1000;
constexpr uint64_t kLeastKbps = 8;
constexpr uint64_t kMostKbps = 10'000'000;

absl::Status BadSetting(absl::string_view field, absl::string_view value,
                        absl::string_view wanted) {
  return absl::InvalidArgumentError(absl::StrCat("the settings' ", field, " is ",
                                                 absl::CHexEscape(value.substr(0, 80)),
                                                 ", must be ", wanted));
}

absl::Status CheckFeatures(const v1::RobotSettings& settings) {
  const uint32_t features = settings.features();
  if (!settings.has_features() || (features >= kLeastFeatures && features <= kMostFeatures)) {
    return absl::OkStatus();
  }
  return BadSetting("features", absl::StrCat(features),
                    absl::StrCat(kLeastFeatures, " to ", kMostFeatures));
}

absl::Status CheckUploadFeatures(const v1::RobotSettings& settings) {
  if (!settings.has_upload_features()) return absl::OkStatus();
  const std::string& text = settings.upload_features();
  uint32_t number = 0;
  const bool is_number = absl::SimpleAtoi(text, &number) && number > 0 && number <= kMostFeatures &&
                         text == absl::StrCat(number);
  if (text == "all" || text == "mapped" || is_number) return absl::OkStatus();
  return BadSetting("upload_features", text,
                    absl::StrCat("all, mapped or a number from 1 to ", kMostFeatures));
}

absl::Status CheckShare(const v1::RobotSettings& settings) {
  constexpr std::array<absl::string_view, 4> kModes = {"none", "corrections", "nearby",
                                                       "everything"};
  if (settings.has_share() && std::ranges::count(kModes, settings.share()) == 0) {
    return BadSetting("share", settings.share(), "none, corrections, nearby or everything");
  }
  if (!settings.has_share_radius_m()) return absl::OkStatus();
  const double radius_m = settings.share_radius_m();
  // No comparison with a number that is none is true.
  if (!(radius_m >= kMinShareRadius_m && radius_m <= kMaxShareRadius_m)) {
    return BadSetting("share_radius_m", absl::StrCat(radius_m),
                      absl::StrCat(kMinShareRadius_m, " to ", kMaxShareRadius_m));
  }
  if (!settings.has_share() || settings.share() == "nearby") return absl::OkStatus();
  return BadSetting(
      "share_radius_m", absl::StrCat(radius_m),
      absl::StrCat("left out with share = ", settings.share(), ": it is of share = nearby"));
}

absl::Status CheckRates(const v1::RobotSettings& settings) {
  const double rate_hz = settings.max_frame_rate_hz();
  if (settings.has_max_frame_rate_hz() && rate_hz != 0 &&
      !(rate_hz >= kLeastRate_hz && rate_hz <= kMostRate_hz)) {
    return BadSetting("max_frame_rate_hz", absl::StrCat(rate_hz),
                      absl::StrCat(kLeastRate_hz, " to ", kMostRate_hz, ", or 0 for all"));
  }
  const uint64_t kbps = settings.uplink_kbps();
  if (kbps == 0 || (kbps >= kLeastKbps && kbps <= kMostKbps)) return absl::OkStatus();
  return BadSetting("uplink_kbps", absl::StrCat(kbps),
                    absl::StrCat(kLeastKbps, " to ", kMostKbps, ", or 0 for no bound"));
}

absl::Status CheckMemoryBudget(const v1::RobotSettings& settings) {
  const uint64_t bytes = settings.memory_budget_bytes();
  if (bytes == 0) return absl::OkStatus();
  if (bytes < kLeastMemoryBudget_bytes || bytes > kMostMemoryBudget_bytes) {
    return BadSetting("memory_budget_bytes", absl::StrCat(bytes),
                      absl::StrCat(kLeastMemoryBudget_bytes, " (", kLeastMemoryBudget_bytes >> 20,
                                   " MiB) to ", kMostMemoryBudget_bytes, ", or 0 for no bound"));
  }
  if (settings.share() != "everything") return absl::OkStatus();
  return BadSetting("memory_budget_bytes", absl::StrCat(bytes),
                    "left out or 0 with share = everything, which has no bound in memory");
}

// Only a robot knows the size of its pictures.
absl::Status CheckMask(const v1::RobotSettings& settings) {
  const std::string& png = settings.mask_png();
  constexpr absl::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
  if (png.empty()) return absl::OkStatus();
  if (absl::string_view(png).substr(0, kPngSignature.size()) == kPngSignature &&
      PictureSize(png).ok() && !IsCutShort(png)) {
    return absl::OkStatus();
  }
  return BadSetting("mask_png", absl::StrCat(png.size(), " bytes that are no whole PNG"), "a PNG");
}

}  // namespace

absl::Status CheckRobotSettings(const v1::RobotSettings& settings) {
  RETURN_IF_ERROR(ParseMissionName(settings.mission()).status());
  if (!settings.agent().empty()) RETURN_IF_ERROR(CheckNameSegment("agent", settings.agent()));
  if (settings.version() == 0) return BadSetting("version", "0", "at least 1");
  RETURN_IF_ERROR(CheckFeatures(settings));
  RETURN_IF_ERROR(CheckUploadFeatures(settings));
  RETURN_IF_ERROR(CheckRates(settings));
  RETURN_IF_ERROR(CheckMemoryBudget(settings));
  RETURN_IF_ERROR(CheckMask(settings));
  return CheckShare(settings);
}

}  // namespace corbslam::services
