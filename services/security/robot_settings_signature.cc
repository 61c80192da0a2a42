#include "services/security/robot_settings_signature.h"

#include <algorithm>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "services/convert/robot_setting_table.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::string_view kSigned = "corbslam-robot-settings-1\n";
constexpr size_t kMostBytes = 64 << 10;

std::string ToBeSigned(const std::string& settings) { return absl::StrCat(kSigned, settings); }

}  // namespace

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
