#include "client_agent/ros2/ros2_parameters.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr char kParameters[] = "ros__parameters";
constexpr char kCommandLine[] = "--ros-args -p";
constexpr int kDeepest = 16;

using Parts = std::vector<absl::string_view>;

// Returns whether the parts of a pattern fit those of a name: "**" is any number of them, "*" one.
bool Fits(absl::Span<const absl::string_view> pattern, absl::Span<const absl::string_view> name) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] == "**") {
    return Fits(pattern.subspan(1), name) || (!name.empty() && Fits(pattern, name.subspan(1)));
  }
  return !name.empty() && (pattern[0] == "*" || pattern[0] == name[0]) &&
         Fits(pattern.subspan(1), name.subspan(1));
}

bool IsOfNode(absl::string_view path, const Ros2Names& names) {
  const Parts pattern = absl::StrSplit(path, '/', absl::SkipEmpty());
  const std::string full_name = names.full_name();
  const Parts name = absl::StrSplit(full_name, '/', absl::SkipEmpty());
  return Fits(pattern, name);
}

// What is written as text in a file is text, whatever it looks like.
std::string ValueOf(const YAML::Node& node) {
  if (!node.IsSequence()) return node.IsScalar() ? node.Scalar() : "";
  std::vector<std::string> values;
  for (const YAML::Node& value : node) values.push_back(ValueOf(value));
  return absl::StrCat("[", absl::StrJoin(values, ", "), "]");
}

void Flatten(const YAML::Node& node, const std::string& name, int depth,
             std::map<std::string, std::string>& values) {
  if (!node.IsMap()) {
    values[name] = ValueOf(node);
    return;
  }
  if (depth > kDeepest) return;
  for (const auto& entry : node) {
    Flatten(entry.second, absl::StrCat(name, name.empty() ? "" : ".", entry.first.Scalar()),
            depth + 1, values);
  }
}

// Walks namespaces down to the nodes' parameters.
void FindParameters(const YAML::Node& node, const std::string& path, const Ros2Names& names,
                    int depth, std::map<std::string, std::string>& values) {
  if (!node.IsMap() || depth > kDeepest) return;
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    if (key != kParameters) {
      FindParameters(entry.second, absl::StrCat(path, "/", key), names, depth + 1, values);
    } else if (IsOfNode(path, names) || path == "/" + names.node()) {
      Flatten(entry.second, "", depth + 1, values);
    }
  }
}

absl::StatusOr<std::map<std::string, std::string>> ReadFile(const std::string& path,
                                                            const Ros2Names& names) {
  std::map<std::string, std::string> values;
  try {
    FindParameters(YAML::LoadFile(path), "", names, 0, values);
  } catch (const YAML::Exception& exception) {
    return absl::InvalidArgumentError(absl::StrCat("--params-file ", path, ": ", exception.what()));
  }
  return values;
}

std::vector<std::string> SplitList(absl::string_view text) {
  if (!absl::ConsumePrefix(&text, "[") || !absl::ConsumeSuffix(&text, "]")) return {};
  return absl::StrSplit(text, absl::ByAnyChar(", "), absl::SkipEmpty());
}

}  // namespace

absl::StatusOr<Ros2Parameters> Ros2Parameters::Read(const Ros2Arguments& arguments,
                                                    const Ros2Names& names) {
  Ros2Parameters parameters;
  for (const std::string& file : arguments.parameter_files) {
    ASSIGN_OR_RETURN(const auto values, ReadFile(file, names));
    for (const auto& [name, value] : values) parameters.given_[name] = {value, file};
  }
  for (const Ros2Rule& rule : arguments.parameters) {
    if (!rule.node.empty() && rule.node != names.node()) continue;
    try {
      parameters.given_[rule.from] = {ValueOf(YAML::Load(rule.to)), kCommandLine};
    } catch (const YAML::Exception& exception) {
      return absl::InvalidArgumentError(
          absl::StrCat(kCommandLine, " ", rule.from, ":=", rule.to, ": ", exception.what()));
    }
  }
  return parameters;
}

const std::string* Ros2Parameters::Find(absl::string_view name) {
  known_.emplace(name);
  const auto found = given_.find(std::string(name));
  return found == given_.end() ? nullptr : &found->second.value;
}

absl::Status Ros2Parameters::Wrong(absl::string_view name, absl::string_view wanted) const {
  const Given& given = given_.at(std::string(name));
  return absl::InvalidArgumentError(absl::StrCat(given.from, ": the parameter ", name, " is '",
                                                 given.value, "', wants ", wanted));
}

absl::Status Ros2Parameters::Take(absl::string_view name, bool& value) {
  const std::string* const given = Find(name);
  if (given == nullptr) return absl::OkStatus();
  if (*given != "true" && *given != "false") return Wrong(name, "true or false");
  value = *given == "true";
  return absl::OkStatus();
}

absl::Status Ros2Parameters::Take(absl::string_view name, double& value, double least,
                                  double most) {
  const std::string* const given = Find(name);
  double number = 0;
  if (given == nullptr) return absl::OkStatus();
  if (!absl::SimpleAtod(*given, &number) || !(number >= least && number <= most)) {
    return Wrong(name, absl::StrCat("a number from ", least, " to ", most));
  }
  value = number;
  return absl::OkStatus();
}

absl::Status Ros2Parameters::Take(absl::string_view name, int& value, int least, int most) {
  const std::string* const given = Find(name);
  int number = 0;
  if (given == nullptr) return absl::OkStatus();
  if (!absl::SimpleAtoi(*given, &number) || number < least || number > most) {
    return Wrong(name, absl::StrCat("a whole number from ", least, " to ", most));
  }
  value = number;
  return absl::OkStatus();
}

absl::Status Ros2Parameters::Take(absl::string_view name, std::string& value) {
  if (const std::string* const given = Find(name); given != nullptr) value = *given;
  return absl::OkStatus();
}

absl::Status Ros2Parameters::Take(absl::string_view name, std::string& value,
                                  const std::vector<absl::string_view>& words) {
  const std::string* const given = Find(name);
  if (given == nullptr) return absl::OkStatus();
  if (std::find(words.begin(), words.end(), *given) == words.end()) {
    return Wrong(name, absl::StrCat("one of ", absl::StrJoin(words, ", ")));
  }
  value = *given;
  return absl::OkStatus();
}

absl::Status Ros2Parameters::Take(absl::string_view name, std::vector<double>& value,
                                  size_t count) {
  const std::string* const given = Find(name);
  if (given == nullptr) return absl::OkStatus();
  std::vector<double> numbers;
  for (const std::string& part : SplitList(*given)) {
    double number = 0;
    if (!absl::SimpleAtod(part, &number) || !std::isfinite(number)) numbers.resize(count);
    numbers.push_back(number);
  }
  if (numbers.size() != count) return Wrong(name, absl::StrCat("a list of ", count, " numbers"));
  value = std::move(numbers);
  return absl::OkStatus();
}

std::vector<std::string> Ros2Parameters::Beginning(absl::string_view prefix) const {
  std::vector<std::string> names;
  for (const auto& [name, given] : given_) {
    if (absl::StartsWith(name, prefix)) names.push_back(name);
  }
  return names;
}

absl::Status Ros2Parameters::CheckAllTaken() const {
  for (const auto& [name, given] : given_) {
    if (known_.count(name) > 0) continue;
    return absl::InvalidArgumentError(absl::StrCat(given.from, ": there is no parameter ", name,
                                                   "; there are ", absl::StrJoin(known_, ", ")));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
