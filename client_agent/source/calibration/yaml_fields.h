// Reads YAML files of fields whole: nothing twice, nothing that a parser would pass over.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_YAML_FIELDS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_YAML_FIELDS_H_

#include <yaml-cpp/yaml.h>

#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Calls `use` with the file's top level, a map; keys differ in it and in every map within. A file
// that begins with %YAML:1.0 is read as OpenCV reads it: "key:value" needs no blank. Returns
// NOT_FOUND where the file can't be opened; INVALID_ARGUMENT names the file and the line of what is
// no YAML, no map, or a key that is there twice. What `use` throws (yaml-cpp does) becomes
// INVALID_ARGUMENT too.
absl::Status UseYamlFields(const std::string& path,
                           const std::function<absl::Status(const YAML::Node&)>& use);

// Does the same with a text; `name` stands for the file in messages.
absl::Status UseYamlText(const std::string& name, const std::string& text,
                         const std::function<absl::Status(const YAML::Node&)>& use);

// Returns the line of a node in its file, from 1 on.
int LineOf(const YAML::Node& node);

// Reads a finite number; returns false where it is none.
bool ReadFinite(const YAML::Node& node, double& number);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_YAML_FIELDS_H_
