#include "client_agent/source/calibration/yaml_fields.h"

#include <cmath>
#include <exception>
#include <filesystem>
#include <set>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

absl::Status CheckKeysDiffer(const std::string& path, const YAML::Node& file) {
  std::set<std::string> keys;
  for (const auto& entry : file) {
    if (!entry.first.IsScalar()) {
      return LineError(path, LineOf(entry.first), "a field's name is no word");
    }
    if (!keys.insert(entry.first.Scalar()).second) {
      return LineError(path, LineOf(entry.first),
                       absl::StrCat(entry.first.Scalar(), " is there twice"));
    }
  }
  return absl::OkStatus();
}

// `load` parses, and may throw, as `use` may.
absl::Status UseLoaded(const std::string& path, const std::function<YAML::Node()>& load,
                       const std::function<absl::Status(const YAML::Node&)>& use) {
  try {
    const YAML::Node file = load();
    if (!file.IsMap()) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": holds no fields, as \"fx: 525.0\""));
    }
    RETURN_IF_ERROR(CheckKeysDiffer(path, file));
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
      path, [&] { return YAML::LoadFile(path); }, use);
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
