#include "services/security/robot_settings_signature.h"

#include <algorithm>
#include <array>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::string_view kSigned = "corbslam-robot-settings-1\n";
constexpr size_t kMostBytes = 64 << 10;

std::string ToBeSigned(const std::string& settings) { return absl::StrCat(kSigned, settings); }

absl::Status BadSetting(absl::string_view field, absl::string_view value,
                        absl::string_view wanted) {
  return absl::InvalidArgumentError(absl::StrCat("the settings' ", field, " is ",
                                                 absl::CHexEscape(value.substr(0, 80)),
                                                 ", must be ", wanted));
}

absl::Status CheckUploadFeatures(const std::string& text) {
  uint32_t number = 0;
  const bool is_number =
      absl::SimpleAtoi(text, &number) && number > 0 && text == absl::StrCat(number);
  if (text == "all" || text == "mapped" || is_number) return absl::OkStatus();
  return BadSetting("upload_features", text, "all, mapped or a number");
}

absl::Status CheckShare(const v1::RobotSettings& settings) {
  constexpr std::array<absl::string_view, 4> kModes = {"none", "corrections", "nearby",
                                                       "everything"};
  if (settings.has_share() && std::ranges::count(kModes, settings.share()) == 0) {
    return BadSetting("share", settings.share(), "none, corrections, nearby or everything");
  }
  const double radius_m = settings.share_radius_m();
  if (!settings.has_share_radius_m() || (radius_m >= 1 && radius_m <= 1e6)) {
    return absl::OkStatus();
  }
  return BadSetting("share_radius_m", absl::StrCat(radius_m), "1 to 1e6");
}

absl::Status CheckRates(const v1::RobotSettings& settings) {
  const double rate_hz = settings.max_frame_rate_hz();
  if (settings.has_max_frame_rate_hz() && rate_hz != 0 && !(rate_hz >= 0.1 && rate_hz <= 1000)) {
    return BadSetting("max_frame_rate_hz", absl::StrCat(rate_hz), "0.1 to 1000, or 0 for all");
  }
  const uint64_t kbps = settings.uplink_kbps();
  if (kbps == 0 || (kbps >= 8 && kbps <= 10'000'000)) return absl::OkStatus();
  return BadSetting("uplink_kbps", absl::StrCat(kbps), "8 to 10000000, or 0 for no bound");
}

}  // namespace

absl::Status CheckRobotSettings(const v1::RobotSettings& settings) {
  RETURN_IF_ERROR(ParseMissionName(settings.mission()).status());
  if (!settings.agent().empty()) RETURN_IF_ERROR(CheckNameSegment("agent", settings.agent()));
  if (settings.version() == 0) return BadSetting("version", "0", "at least 1");
  if (settings.has_features() && (settings.features() < 1 || settings.features() > 20'000)) {
    return BadSetting("features", absl::StrCat(settings.features()), "1 to 20000");
  }
  if (settings.has_upload_features()) {
    RETURN_IF_ERROR(CheckUploadFeatures(settings.upload_features()));
  }
  RETURN_IF_ERROR(CheckRates(settings));
  return CheckShare(settings);
}

absl::StatusOr<v1::SignedRobotSettings> SignRobotSettings(const v1::RobotSettings& settings,
                                                          absl::string_view private_key_pem) {
  RETURN_IF_ERROR(CheckRobotSettings(settings));
  ASSIGN_OR_RETURN(const Ed25519Key key, ReadEd25519PrivateKey(private_key_pem));
  v1::SignedRobotSettings made;
  made.set_settings(settings.SerializeAsString());
  if (made.settings().size() > kMostBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("the settings take ", made.settings().size(), " bytes, of which the mask is ",
                     settings.mask_png().size(), "; at most ", kMostBytes, " are allowed"));
  }
  ASSIGN_OR_RETURN(*made.mutable_signature(), SignBytes(ToBeSigned(made.settings()), key));
  return made;
}

absl::StatusOr<v1::RobotSettings> VerifyRobotSettings(const v1::SignedRobotSettings& from,
                                                      const std::vector<Ed25519Key>& keys) {
  const std::string bytes = ToBeSigned(from.settings());
  const auto is_signed_by = [&](const Ed25519Key& key) {
    return IsSignedBy(bytes, from.signature(), key);
  };
  if (std::ranges::none_of(keys, is_signed_by)) {
    return absl::PermissionDeniedError("their signature is of none of the keys that are trusted");
  }
  v1::RobotSettings settings;
  if (!settings.ParseFromString(from.settings())) {
    return absl::InvalidArgumentError("they can't be read as a RobotSettings");
  }
  RETURN_IF_ERROR(CheckRobotSettings(settings));
  return settings;
}

}  // namespace corbslam::services
