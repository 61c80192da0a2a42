#include "client_agent/source/calibration/yaml_fields.h"

#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

// Parts that a file names again (&a, *a) count each time, and may be nested.
constexpr int kMostParts = 100'000;

// Looks at every map in a file. `parts` counts those that were looked at.
absl::Status CheckKeysDiffer(const std::string& path, const YAML::Node& part, int& parts) {
  if (++parts > kMostParts) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": holds more than ", kMostParts, " parts"));
  }
  if (part.IsSequence()) {
    for (const YAML::Node& entry : part) {
      if (!entry.IsScalar()) RETURN_IF_ERROR(CheckKeysDiffer(path, entry, parts));
    }
  }
  if (!part.IsMap()) return absl::OkStatus();
  std::set<std::string> keys;
  for (const auto& entry : part) {
    if (!entry.first.IsScalar()) {
      return LineError(path, LineOf(entry.first), "a field's name is no word");
    }
    if (!keys.insert(entry.first.Scalar()).second) {
      return LineError(path, LineOf(entry.first),
                       absl::StrCat(entry.first.Scalar(), " is there twice"));
    }
    RETURN_IF_ERROR(CheckKeysDiffer(path, entry.second, parts));
  }
  return absl::OkStatus();
}

// Returns where a line's "key:" ends, if what follows stands there without a blank; else 0.
size_t EndOfCrowdedKey(absl::string_view line) {
  size_t at = 0;
  while (at < line.size() && line[at] == ' ') ++at;
  const size_t begin = at;
  const auto is_of_key = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-';
  };
  while (at < line.size() && is_of_key(line[at])) ++at;
  const bool is_key = at > begin && absl::ascii_isalpha(static_cast<unsigned char>(line[begin]));
  if (!is_key || at + 1 >= line.size() || line[at] != ':') return 0;
  return absl::ascii_isspace(static_cast<unsigned char>(line[at + 1])) ? 0 : at + 1;
}

// OpenCV writes and reads YAML 1.0 in which nothing need stand between "key:" and its value, which
// YAML's own parsers take for a word.
std::string WithBlanks(std::string text) {
  if (!absl::StartsWith(text, "%YAML:1.0")) return text;
  std::vector<std::string> lines = absl::StrSplit(text, '\n');
  for (std::string& line : lines) {
    if (const size_t end = EndOfCrowdedKey(line); end > 0) line.insert(end, " ");
  }
  return absl::StrJoin(lines, "\n");
}

std::string ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw YAML::BadFile(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// `load` parses, and may throw, as `use` may.
absl::Status UseLoaded(const std::string& path, const std::function<YAML::Node()>& load,
                       const std::function<absl::Status(const YAML::Node&)>& use) {
  try {
    const YAML::Node file = load();
    if (!file.IsMap()) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": holds no fields, as \"fx: 525.0\""));
    }
    int parts = 0;
    RETURN_IF_ERROR(CheckKeysDiffer(path, file, parts));
    return use(file);
  } catch (const std::exception& exception) {
    // These are the parser's own errors (with line and column), and those of the standard library
    // that it lets through.
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", exception.what()));
  }
}

}  // namespace

absl::Status UseYamlFields(const std::string& path,
                           const std::function<absl::Status(const YAML::Node&)>& use) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return absl::NotFoundError(absl::StrCat("cannot open ", path));
  }
  return UseLoaded(
      path, [&] { return YAML::Load(WithBlanks(ReadAll(path))); }, use);
}

absl::Status UseYamlText(const std::string& name, const std::string& text,
                         const std::function<absl::Status(const YAML::Node&)>& use) {
  return UseLoaded(
      name, [&] { return YAML::Load(text); }, use);
}

int LineOf(const YAML::Node& node) { return node.Mark().line + 1; }

bool ReadFinite(const YAML::Node& node, double& number) {
  return node.IsDefined() && node.IsScalar() && absl::SimpleAtod(node.Scalar(), &number) &&
         std::isfinite(number);
}

}  // namespace corbslam::client_agent
