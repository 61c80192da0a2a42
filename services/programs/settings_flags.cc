#include "services/programs/settings_flags.h"

#include <glog/logging.h>

#include <map>

#include "absl/strings/str_cat.h"
#include "services/programs/kept_settings.h"
#include "services/programs/settings_book.h"
#include "services/security/ed25519.h"
#include "services/security/pem_files.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

void Set(const RobotSetting& row, const v1::RobotSettings& from, SettableFlags& flags) {
  if (row.is_file) flags.mask_png = from.mask_png();
  for (const Setting& setting : RowsOf(flags)) {
    if (setting.flag != absl::StrCat("--", row.flag)) continue;
    const std::string wrong = ReadSetting(setting, SettingText(row, from));
    // The table's bounds are the flag's or narrower.
    LOG_IF(DFATAL, !wrong.empty()) << "the settings' " << row.field << " " << wrong;
  }
}

}  // namespace

std::vector<Setting> RowsOf(SettingsFlags& flags) {
  return {{"--settings-key", &flags.key,
           "PEM file of the Ed25519 public keys whose settings for robots are taken from the map "
           "store; without: none are",
           kRare},
          {"--settings-kept", &flags.kept,
           "File for those that were taken: they hold until the map store is reached, and no older "
           "ones are taken after a restart",
           kRare}};
}

absl::Status CheckSettingsFlags(const SettingsFlags& flags, bool has_server) {
  if (flags.key.empty() && flags.kept.empty()) return absl::OkStatus();
  if (flags.key.empty()) {
    return absl::InvalidArgumentError("--settings-kept needs --settings-key");
  }
  if (!has_server) return absl::InvalidArgumentError("--settings-key needs --server");
  return absl::OkStatus();
}

absl::Status CheckSettingsFiles(const SettingsFlags& flags) {
  if (flags.key.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string pem, ReadSecurityFile("--settings-key", flags.key));
  const absl::Status keys = ReadEd25519PublicKeys("settings key", pem).status();
  if (!keys.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--settings-key ", flags.key, ": ", keys.message()));
  }
  if (flags.kept.empty()) return absl::OkStatus();
  const absl::Status kept = ReadKeptSettings(flags.kept).status();
  return kept.ok() ? kept : absl::InvalidArgumentError(kept.message());
}

ShareScope ScopeOf(const SettableFlags& flags, bool is_bounded) {
  ShareScope scope;
  scope.mode = flags.share.value_or(is_bounded ? ShareMode::kNearby : ShareMode::kEverything);
  if (scope.mode == ShareMode::kNearby) {
    scope.radius_m = flags.share_radius_m.value_or(scope.radius_m);
  }
  return scope;
}

absl::Status CheckShare(const SettableFlags& flags, bool is_bounded, bool has_server) {
  const ShareMode mode = ScopeOf(flags, is_bounded).mode;
  if (flags.share_radius_m.has_value() && mode != ShareMode::kNearby) {
    return absl::InvalidArgumentError(
        absl::StrCat("--share-radius is ", *flags.share_radius_m, ", but needs --share nearby"));
  }
  if (has_server || mode == ShareMode::kEverything) return absl::OkStatus();
  return absl::InvalidArgumentError("--share needs --server");
}

std::set<std::string> GivenFlags(const CLI::App& app) {
  SettableFlags flags;
  std::set<std::string> given = {"--outbox-mb"};
  for (const Setting& setting : RowsOf(flags)) given.insert(setting.flag);
  std::erase_if(given, [&app](const std::string& flag) {
    const CLI::Option* option = app.get_option_no_throw(flag);
    return option == nullptr || option->count() == 0;
  });
  return given;
}

std::vector<std::string> UseSettings(const v1::RobotSettings& of_all, const v1::RobotSettings& own,
                                     const std::set<std::string>& given, SettableFlags& flags) {
  // A robot's own line takes the place of that of all.
  std::map<std::string, std::string> lines;
  for (const v1::RobotSettings* from : {&of_all, &own}) {
    for (const RobotSetting& row : RobotSettingTable()) {
      if (!HasSetting(row, *from)) continue;
      const std::string line =
          absl::StrCat(row.flag, " = ", SettingText(row, *from), "  # ", NameSettings(*from));
      const bool stays = given.contains(absl::StrCat("--", row.flag));
      lines[row.flag] = stays ? absl::StrCat("# ", line, "; the flag was given and stays") : line;
      if (!stays) Set(row, *from, flags);
    }
  }
  std::vector<std::string> said;
  for (const auto& [flag, line] : lines) said.push_back(line);
  return said;
}

}  // namespace corbslam::services
