// Keeps the settings that a robot has taken from its map store: those that a key that it trusts has
// signed for it and that it can run with, the newest of each.
#ifndef CORBSLAM_SERVICES_PROGRAMS_SETTINGS_BOOK_H_
#define CORBSLAM_SERVICES_PROGRAMS_SETTINGS_BOOK_H_

#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/robot_settings.pb.h"
#include "services/security/ed25519.h"

namespace corbslam::services {

// Not thread-safe.
class SettingsBook {
 public:
  SettingsBook(std::vector<Ed25519Key> keys, std::string mission, std::string agent);

  // Returns why the robot can't run with settings for all robots and with its own, together.
  using Fits =
      std::function<absl::Status(const v1::RobotSettings& of_all, const v1::RobotSettings& own)>;

  struct Taken {
    // At least one was newer than what the book had, and fits.
    bool changed = false;
    // The list is another one than before.
    bool learned = false;
    // Why others were not taken: whose they are, and what is wrong.
    std::vector<absl::Status> refused = {};
  };
  // Takes what is good, new and fits (null: all does). What the book has already is no error; an
  // older version is, and another text under the same version. Where what is new does not fit
  // together, each is tried alone; one that does not fit leaves all as it was.
  Taken Take(const v1::RobotSettingsList& list, const Fits& fits = nullptr);

  // Returns those for all robots of the mission, and those for this one; without fields: none.
  const v1::RobotSettings& of_all() const { return of_all_.settings; }
  const v1::RobotSettings& own() const { return own_.settings; }
  // Returns them as they were signed, each followed by a newer one that does not fit: a process
  // that takes the list goes on as this one, and an older one is not taken in place of either.
  v1::RobotSettingsList list() const;

 private:
  struct Entry {
    v1::RobotSettings settings;
    v1::SignedRobotSettings from;
    // A newer one that does not fit; 0: there is none.
    uint64_t unfit_version = 0;
    v1::SignedRobotSettings unfit;
  };
  struct Verified {
    v1::RobotSettings settings;
    v1::SignedRobotSettings from;
  };
  // Returns settings for this robot that one of the keys signed.
  absl::StatusOr<Verified> Verify(const v1::SignedRobotSettings& from) const;
  Entry& EntryOf(const Verified& verified) {
    return verified.settings.agent().empty() ? of_all_ : own_;
  }
  // Returns whether they are newer than what the book has; an error where they are older.
  absl::StatusOr<bool> IsNew(const Verified& verified);
  void Put(const Verified& verified);
  void TakeEach(const std::vector<Verified>& fresh, const Fits& fits, Taken& taken);

  const std::vector<Ed25519Key> keys_;
  const std::string mission_;
  const std::string agent_;
  Entry of_all_;
  Entry own_;
};

// Returns "version 7 of missions/lab/agents/alpha".
std::string NameSettings(const v1::RobotSettings& settings);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_SETTINGS_BOOK_H_
