// Keeps the settings that a robot has taken from its map store: those that a key that it trusts has
// signed for it, the newest of each.
#ifndef CORBSLAM_SERVICES_PROGRAMS_SETTINGS_BOOK_H_
#define CORBSLAM_SERVICES_PROGRAMS_SETTINGS_BOOK_H_

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

  struct Taken {
    // At least one was newer than what the book had.
    bool changed = false;
    // Why others were not taken: whose they are, and what is wrong.
    std::vector<absl::Status> refused = {};
  };
  // Takes what is good and new. What the book has already is no error; an older version is, and
  // another text under the same version.
  Taken Take(const v1::RobotSettingsList& list);

  // Returns those for all robots of the mission, and those for this one; without fields: none.
  const v1::RobotSettings& of_all() const { return of_all_.settings; }
  const v1::RobotSettings& own() const { return own_.settings; }
  // Returns them as they were signed.
  v1::RobotSettingsList list() const;

 private:
  struct Entry {
    v1::RobotSettings settings;
    v1::SignedRobotSettings from;
  };
  absl::Status TakeOne(const v1::SignedRobotSettings& from, bool& changed);

  const std::vector<Ed25519Key> keys_;
  const std::string mission_;
  const std::string agent_;
  Entry of_all_;
  Entry own_;
};

// Returns "version 7 of missions/lab/agents/alpha".
std::string NameSettings(const v1::RobotSettings& settings);

// Reads what WriteKept wrote; empty if there is no such file. INVALID_ARGUMENT for what it did not
// write.
absl::StatusOr<v1::RobotSettingsList> ReadKept(const std::string& path);
// Replaces the file as a whole.
absl::Status WriteKept(const v1::RobotSettingsList& list, const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_SETTINGS_BOOK_H_
