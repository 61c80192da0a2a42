#include "services/programs/settings_flags.h"

#include <functional>
#include <map>

#include "absl/strings/str_cat.h"
#include "services/command_line/help_formatter.h"
#include "services/programs/kept_settings.h"
#include "services/programs/settings_book.h"
#include "services/security/ed25519.h"
#include "services/security/pem_files.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

ShareMode ShareModeOf(const std::string& word) {
  if (word == "none") return ShareMode::kNone;
  if (word == "corrections") return ShareMode::kCorrections;
  return word == "nearby" ? ShareMode::kNearby : ShareMode::kEverything;
}

// Sets flags of one message after the other; a line of a later one takes the place of an earlier.
class FlagSetter {
 public:
  FlagSetter(const std::set<std::string>& given, SettableFlags& flags)
      : given_(given), flags_(flags) {}

  void Use(const v1::RobotSettings& from) {
    from_ = NameSettings(from);
    if (from.has_features()) {
      Set("features", absl::StrCat(from.features()),
          [&] { flags_.features = static_cast<int>(from.features()); });
    }
    if (from.has_max_frame_rate_hz()) {
      Set("max-rate", absl::StrCat(from.max_frame_rate_hz()),
          [&] { flags_.max_rate_hz = from.max_frame_rate_hz(); });
    }
    if (from.has_upload_features()) {
      const std::string upload = "features=" + from.upload_features();
      Set("upload", upload, [&] { flags_.upload = upload; });
    }
    if (from.has_memory_budget_bytes()) {
      Set("memory-budget", absl::StrCat(from.memory_budget_bytes()),
          [&] { flags_.memory.budget_bytes = from.memory_budget_bytes(); });
    }
    if (from.has_uplink_kbps()) {
      Set("uplink-kbps", absl::StrCat(from.uplink_kbps()),
          [&] { flags_.link.uplink_kbps = from.uplink_kbps(); });
    }
    UseShare(from);
    if (from.has_mask_png()) {
      Set("mask", absl::StrCat(from.mask_png().size(), " bytes of PNG"),
          [&] { flags_.mask_png = from.mask_png(); });
    }
  }
  std::vector<std::string> lines() const {
    std::vector<std::string> lines;
    for (const auto& [flag, line] : lines_) lines.push_back(line);
    return lines;
  }

 private:
  void UseShare(const v1::RobotSettings& from) {
    if (from.has_share()) {
      Set("share", from.share(), [&] { flags_.share.mode = ShareModeOf(from.share()); });
    }
    if (from.has_share_radius_m()) {
      Set("share-radius", absl::StrCat(from.share_radius_m()), [&] {
        flags_.share.radius_m = from.share_radius_m();
        flags_.share.has_radius = true;
      });
    }
  }
  void Set(const std::string& flag, const std::string& value, const std::function<void()>& set) {
    if (given_.contains("--" + flag)) {
      lines_[flag] =
          absl::StrCat("# ", flag, " = ", value, "  # ", from_, "; the flag was given and stays");
      return;
    }
    set();
    lines_[flag] = absl::StrCat(flag, " = ", value, "  # ", from_);
  }

  const std::set<std::string>& given_;
  SettableFlags& flags_;
  std::string from_;
  std::map<std::string, std::string> lines_;
};

}  // namespace

void AddSettingsFlags(CLI::App& app, SettingsFlags& flags, double& max_rate_hz) {
  app.add_option("--settings-key", flags.key,
                 "PEM file of the Ed25519 public keys whose settings for robots are taken from the "
                 "map store; without: none are")
      ->group(kRareGroup);
  app.add_option("--settings-kept", flags.kept,
                 "File for those that were taken: they hold until the map store is reached, and no "
                 "older ones are taken after a restart")
      ->group(kRareGroup);
  app.add_option("--max-rate", max_rate_hz,
                 "Frames a second that are tracked at most, by their own times; 0: all")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str()
      ->group(kRareGroup);
}

absl::Status CheckSettingsFlags(const SettingsFlags& flags, bool has_server) {
  if (flags.key.empty()) {
    if (flags.kept.empty()) return absl::OkStatus();
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
  const absl::Status kept = ReadKept(flags.kept).status();
  return kept.ok() ? kept : absl::InvalidArgumentError(kept.message());
}

std::set<std::string> GivenFlags(const CLI::App& app) {
  std::set<std::string> given;
  for (const char* flag : {"--features", "--max-rate", "--upload", "--memory-budget",
                           "--uplink-kbps", "--share", "--share-radius", "--outbox-mb"}) {
    const CLI::Option* option = app.get_option_no_throw(flag);
    if (option != nullptr && option->count() > 0) given.insert(flag);
  }
  return given;
}

std::vector<std::string> UseSettings(const v1::RobotSettings& of_all, const v1::RobotSettings& own,
                                     const std::set<std::string>& given, SettableFlags& flags) {
  FlagSetter setter(given, flags);
  setter.Use(of_all);
  setter.Use(own);
  return setter.lines();
}

}  // namespace corbslam::services
