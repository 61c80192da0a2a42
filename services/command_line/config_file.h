// Flags from a file in TOML: name = value a line; [command] or [command.command] before those of
// one of the tool's commands. Above all such lines stands what every command takes that has it.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_CONFIG_FILE_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_CONFIG_FILE_H_

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

namespace corbslam {

// Not thread-safe. The app outlives it.
class ConfigFile : public CLI::ConfigTOML {
 public:
  explicit ConfigFile(CLI::App* app) : app_(app) {}

  // What the file sets, without what the environment sets. Throws CLI::ConfigError, naming file,
  // line and key, for what is no flag.
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

  // FILE:LINE of what was taken, by flag's name.
  const std::map<std::string, std::string>& places() const { return places_; }

 private:
  // FILE:LINE, as far as it can be told.
  std::string Place(const std::string& text, const CLI::ConfigItem& item) const;
  // The program or the command that the item is for; null: none has such a flag.
  CLI::App* FindOwner(CLI::ConfigItem& item) const;

  CLI::App* const app_;
  // CLI11 reads through a constant object.
  mutable std::map<std::string, std::string> places_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_CONFIG_FILE_H_
