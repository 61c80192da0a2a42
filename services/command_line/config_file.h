// Reads flags from a file in TOML: name = value a line; [command] or [command.command] stands
// before the lines of one of the tool's commands. Lines above all sections count for every command
// that has the flag.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_CONFIG_FILE_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_CONFIG_FILE_H_

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

namespace corbslam::services {

// Reads the file for CLI11. Not thread-safe. The app must outlive it.
class ConfigFile : public CLI::ConfigTOML {
 public:
  explicit ConfigFile(CLI::App* app) : app_(app) {}

  // Returns what the file sets, without what the environment sets. Throws CLI::ConfigError, naming
  // file, line and key, for what is no flag.
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

  // Returns FILE:LINE of what was taken, by the flag's name.
  const std::map<std::string, std::string>& places() const { return places_; }

 private:
  // Returns FILE:LINE of the item; FILE alone if the line is not found.
  std::string Place(const std::string& text, const CLI::ConfigItem& item) const;
  // Returns the program or the command that the item is for; null if there is no such command.
  CLI::App* FindOwner(CLI::ConfigItem& item) const;

  CLI::App* const app_;
  // It is mutable, since CLI11 reads through a constant object.
  mutable std::map<std::string, std::string> places_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_CONFIG_FILE_H_
