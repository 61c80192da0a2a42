// Keeps the settings that a robot has taken in a file, from process to process.
#ifndef CORBSLAM_SERVICES_PROGRAMS_KEPT_SETTINGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_KEPT_SETTINGS_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/robot_settings.pb.h"

namespace corbslam::services {

// Reads what WriteKeptSettings wrote; empty if there is no such file. DATA_LOSS, with what to do,
// for one that is empty, cut short or damaged, or that WriteKeptSettings did not write; UNAVAILABLE
// for one that can't be read.
absl::StatusOr<v1::RobotSettingsList> ReadKeptSettings(const std::string& path);

// Replaces the file as a whole, and durably: a loss of power leaves the old one or the new one. A
// file that ReadKeptSettings can't take is not overwritten, but gets ".damaged" at the end of its
// name.
absl::Status WriteKeptSettings(const v1::RobotSettingsList& list, const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_KEPT_SETTINGS_H_
