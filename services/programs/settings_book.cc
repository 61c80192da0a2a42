#include "services/programs/settings_book.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "services/convert/resource_names.h"
#include "services/security/robot_settings_signature.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

std::string NameSettings(const v1::RobotSettings& settings) {
  const std::string mission = absl::CHexEscape(settings.mission().substr(0, 80));
  const std::string agent =
      settings.agent().empty()
          ? ""
          : absl::StrCat("/agents/", absl::CHexEscape(settings.agent().substr(0, 80)));
  return absl::StrCat("version ", settings.version(), " of ", mission, agent);
}

SettingsBook::SettingsBook(std::vector<Ed25519Key> keys, std::string mission, std::string agent)
    : keys_(std::move(keys)), mission_(MissionName(mission)), agent_(std::move(agent)) {}

absl::Status SettingsBook::TakeOne(const v1::SignedRobotSettings& from, bool& changed) {
  const absl::StatusOr<v1::RobotSettings> settings = VerifyRobotSettings(from, keys_);
  if (!settings.ok()) {
    // Whoever made them up wrote this name, too.
    v1::RobotSettings said;
    const bool is_read = said.ParseFromString(from.settings());
    return absl::Status(
        settings.status().code(),
        absl::StrCat("settings that call themselves ",
                     is_read ? NameSettings(said) : std::string("nothing that can be read"),
                     " are refused: ", settings.status().message()));
  }
  const std::string name = NameSettings(*settings);
  if (settings->mission() != mission_ ||
      (!settings->agent().empty() && settings->agent() != agent_)) {
    return absl::FailedPreconditionError(absl::StrCat(
        "settings ", name, " are refused: this robot is ", mission_, "/agents/", agent_));
  }
  Entry& entry = settings->agent().empty() ? of_all_ : own_;
  const uint64_t last = entry.settings.version();
  const bool is_known = entry.from.settings() == from.settings();
  if (is_known) return absl::OkStatus();
  if (settings->version() <= last) {
    return absl::FailedPreconditionError(absl::StrCat(
        "settings ", name, " are refused: this robot has taken version ", last, " before",
        settings->version() == last ? ", which says something else" : ", which is newer"));
  }
  entry = {*settings, from};
  changed = true;
  return absl::OkStatus();
}

SettingsBook::Taken SettingsBook::Take(const v1::RobotSettingsList& list) {
  Taken taken;
  for (const v1::SignedRobotSettings& entry : list.settings()) {
    if (const absl::Status one = TakeOne(entry, taken.changed); !one.ok()) {
      taken.refused.push_back(one);
    }
  }
  return taken;
}

v1::RobotSettingsList SettingsBook::list() const {
  v1::RobotSettingsList list;
  for (const Entry* entry : {&of_all_, &own_}) {
    if (entry->settings.version() > 0) *list.add_settings() = entry->from;
  }
  return list;
}

absl::StatusOr<v1::RobotSettingsList> ReadKept(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return v1::RobotSettingsList();
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  v1::RobotSettingsList list;
  if (file && list.ParseFromString(bytes)) return list;
  return absl::InvalidArgumentError(
      absl::StrCat("--settings-kept ", path,
                   " can't be read as settings that a robot kept: delete "
                   "it, or name another file"));
}

absl::Status WriteKept(const v1::RobotSettingsList& list, const std::string& path) {
  const std::string whole = path + ".new";
  std::ofstream file(whole, std::ios::binary | std::ios::trunc);
  file << list.SerializeAsString();
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(whole, path, error);
  if (file && !error) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("can't write --settings-kept ", path));
}

}  // namespace corbslam::services
