// Signs the settings of a mission's robots and verifies them (docs/robot.md). What is signed is
// "corbslam-robot-settings-1", a line's end, and the bytes of one serialised v1::RobotSettings as
// they stand in v1::SignedRobotSettings: whoever hands them on never serialises them anew.
#ifndef CORBSLAM_SERVICES_SECURITY_ROBOT_SETTINGS_SIGNATURE_H_
#define CORBSLAM_SERVICES_SECURITY_ROBOT_SETTINGS_SIGNATURE_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "corbslam/v1/robot_settings.pb.h"
#include "services/security/ed25519.h"

namespace corbslam::services {

// Signs settings that CheckRobotSettings (robot_setting_table.h) takes. `private_key_pem` holds
// one Ed25519 private key.
absl::StatusOr<v1::SignedRobotSettings> SignRobotSettings(const v1::RobotSettings& settings,
                                                          absl::string_view private_key_pem);

// Returns the settings if one of the keys signed them: PERMISSION_DENIED if none did,
// INVALID_ARGUMENT for what can't be read or CheckRobotSettings refuses.
absl::StatusOr<v1::RobotSettings> VerifyRobotSettings(const v1::SignedRobotSettings& from,
                                                      const std::vector<Ed25519Key>& keys);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_ROBOT_SETTINGS_SIGNATURE_H_
