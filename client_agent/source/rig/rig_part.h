// Reads the fields of a part of a rig file. Internal to the rig files' reader.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_PART_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_PART_H_

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/calibration/yaml_numbers.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {

// `rig: 1` says that a file is a rig file, in this format.
inline constexpr int kRigFormat = 1;

// The fields of a part of the file, which is a map: each is known and read once.
class Part {
 public:
  Part(std::string path, std::string name, const YAML::Node& node)
      : path_(std::move(path)), name_(std::move(name)), node_(node) {}

  absl::Status CheckFields(const std::set<std::string>& known) const {
    if (!node_.IsMap()) {
      return Bad(name_.empty() ? "holds no fields"
                               : absl::StrCat(absl::StripSuffix(name_, "."), " holds no fields"));
    }
    std::set<std::string> seen;
    for (const auto& entry : node_) {
      const std::string key = entry.first.Scalar();
      if (!known.contains(key)) {
        return LineError(
            path_, LineOf(entry.first),
            absl::StrCat("unknown field ", key, ": known are ", absl::StrJoin(known, ", ")));
      }
      if (!seen.insert(key).second) {
        return LineError(path_, LineOf(entry.first), absl::StrCat(key, " is there twice"));
      }
    }
    return absl::OkStatus();
  }
  bool Has(const char* field) const { return node_[field].IsDefined(); }
  YAML::Node operator[](const char* field) const { return node_[field]; }
  std::string Named(const char* field) const { return absl::StrCat(name_, field); }
  const std::string& path() const { return path_; }

  absl::StatusOr<std::vector<double>> Numbers(const char* field, size_t least, size_t most) const {
    if (!Has(field)) return Bad(absl::StrCat(Named(field), " is missing"));
    return ReadNumbers(node_[field], path_, Named(field), least, most);
  }
  absl::Status Set(const char* field, double& number) const {
    if (!Has(field)) return absl::OkStatus();
    ASSIGN_OR_RETURN(number, ReadNumber(node_[field], path_, Named(field)));
    return absl::OkStatus();
  }
  absl::Status Set(const char* field, std::optional<double>& number) const {
    return Has(field) ? Set(field, number.emplace()) : absl::OkStatus();
  }
  absl::Status Set(const char* field, bool& flag) const {
    if (!Has(field)) return absl::OkStatus();
    const std::string word = node_[field].IsScalar() ? node_[field].Scalar() : "";
    const std::string lower = absl::AsciiStrToLower(word);  // YAML has true, True and TRUE.
    if (lower != "true" && lower != "false") {
      return Bad(absl::StrCat(Named(field), " is '", word, "', must be true or false"));
    }
    flag = lower == "true";
    return absl::OkStatus();
  }
  absl::StatusOr<std::string> Word(const char* field) const {
    if (Has(field) && node_[field].IsScalar()) return node_[field].Scalar();
    return Bad(absl::StrCat(Named(field), " is missing"));
  }
  absl::StatusOr<Rigid3d> Motion(const char* field) const {
    ASSIGN_OR_RETURN(const std::vector<double> rows, Numbers(field, 16, 16));
    return ToRigid(rows, path_, Named(field));
  }
  absl::Status Bad(absl::string_view what) const {
    return absl::InvalidArgumentError(absl::StrCat(path_, ": ", what));
  }

 private:
  std::string path_;
  std::string name_;  // Written before its fields' names: "cameras[0].".
  YAML::Node node_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_PART_H_
