#include "services/programs/settings_book.h"

#include <algorithm>
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

absl::StatusOr<SettingsBook::Verified> SettingsBook::Verify(
    const v1::SignedRobotSettings& from) const {
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
  if (settings->mission() != mission_ ||
      (!settings->agent().empty() && settings->agent() != agent_)) {
    return absl::FailedPreconditionError(absl::StrCat("settings ", NameSettings(*settings),
                                                      " are refused: this robot is ", mission_,
                                                      "/agents/", agent_));
  }
  return Verified{*settings, from};
}

absl::StatusOr<bool> SettingsBook::IsNew(const Verified& verified) {
  const Entry& entry = EntryOf(verified);
  const std::string& bytes = verified.from.settings();
  if (entry.from.settings() == bytes) return false;
  // What does not fit is tried again: the robot may have other flags by now.
  if (entry.unfit.settings() == bytes) return true;
  const uint64_t last = std::max(entry.settings.version(), entry.unfit_version);
  const uint64_t version = verified.settings.version();
  if (version > last) return true;
  return absl::FailedPreconditionError(
      absl::StrCat("settings ", NameSettings(verified.settings), " are refused: this robot has ",
                   last == entry.unfit_version ? "seen" : "taken", " version ", last, " before",
                   version == last ? ", which says something else" : ", which is newer"));
}

void SettingsBook::Put(const Verified& verified) {
  Entry& entry = EntryOf(verified);
  if (verified.settings.version() <= entry.settings.version()) return;
  entry.settings = verified.settings;
  entry.from = verified.from;
  if (entry.unfit_version > verified.settings.version()) return;
  entry.unfit_version = 0;
  entry.unfit.Clear();
}

void SettingsBook::TakeEach(const std::vector<Verified>& fresh, const Fits& fits, Taken& taken) {
  for (const Verified& verified : fresh) {
    Entry& entry = EntryOf(verified);
    const Entry before = entry;
    Put(verified);
    const absl::Status fit = fits(of_all_.settings, own_.settings);
    if (fit.ok()) {
      taken.changed = true;
      continue;
    }
    entry = before;
    taken.refused.push_back(absl::Status(
        fit.code(),
        absl::StrCat("settings ", NameSettings(verified.settings),
                     " don't fit this robot, which goes on as it was: ", fit.message())));
    if (verified.settings.version() < entry.unfit_version) continue;
    entry.unfit_version = verified.settings.version();
    entry.unfit = verified.from;
  }
}

SettingsBook::Taken SettingsBook::Take(const v1::RobotSettingsList& list, const Fits& fits) {
  Taken taken;
  std::vector<Verified> fresh;
  for (const v1::SignedRobotSettings& from : list.settings()) {
    const absl::StatusOr<Verified> verified = Verify(from);
    const absl::StatusOr<bool> is_new = verified.ok() ? IsNew(*verified) : verified.status();
    if (!is_new.ok()) taken.refused.push_back(is_new.status());
    if (is_new.ok() && *is_new) fresh.push_back(*verified);
  }
  if (fresh.empty()) return taken;
  const std::string list_before = this->list().SerializeAsString();
  const Entry of_all_before = of_all_;
  const Entry own_before = own_;
  for (const Verified& verified : fresh) Put(verified);
  if (fits == nullptr || fits(of_all_.settings, own_.settings).ok()) {
    taken.changed = true;
  } else {
    of_all_ = of_all_before;
    own_ = own_before;
    TakeEach(fresh, fits, taken);
  }
  taken.learned = this->list().SerializeAsString() != list_before;
  return taken;
}

v1::RobotSettingsList SettingsBook::list() const {
  v1::RobotSettingsList list;
  for (const Entry* entry : {&of_all_, &own_}) {
    if (entry->settings.version() > 0) *list.add_settings() = entry->from;
    if (entry->unfit_version > 0) *list.add_settings() = entry->unfit;
  }
  return list;
}

}  // namespace corbslam::services
