#include "client_agent/ros2/ros2_names.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::string_view kTopicPrefix = "rt";
// DDS allows 256 characters.
constexpr size_t kLongest = 240;

// Names between slashes: letters, digits and '_', no digit first.
bool IsToken(absl::string_view token) {
  return !token.empty() && !absl::ascii_isdigit(static_cast<unsigned char>(token[0])) &&
         std::all_of(token.begin(), token.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_';
         });
}

absl::Status CheckName(absl::string_view rule, absl::string_view name) {
  absl::string_view rest = name;
  if (!absl::ConsumePrefix(&rest, "~/")) absl::ConsumePrefix(&rest, "/");
  bool is_good = name.size() <= kLongest;
  for (const absl::string_view token : absl::StrSplit(rest, '/')) is_good &= IsToken(token);
  if (is_good) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "--ros-args -r ", rule, ": '", name,
      "' is no name: parts between '/' have letters, digits and '_', and no digit first"));
}

}  // namespace

absl::StatusOr<Ros2Names> Ros2Names::Make(absl::string_view node,
                                          const std::vector<Ros2Rule>& remaps) {
  Ros2Names names;
  names.node_ = std::string(node);
  for (const Ros2Rule& rule : remaps) {
    if (!rule.node.empty() && rule.node != node) continue;
    const std::string text = absl::StrCat(rule.from, ":=", rule.to);
    if (rule.from == "__ns") {
      names.namespace_ = absl::StrCat(absl::StartsWith(rule.to, "/") ? "" : "/", rule.to);
      if (names.namespace_ != "/") RETURN_IF_ERROR(CheckName(text, names.namespace_));
    } else if (rule.from == "__node" || rule.from == "__name") {
      if (!IsToken(rule.to)) return CheckName(text, "/" + rule.to + "/");
      names.node_ = rule.to;
    }
  }
  for (const Ros2Rule& rule : remaps) {
    if (absl::StartsWith(rule.from, "__") || (!rule.node.empty() && rule.node != node)) continue;
    absl::string_view from = rule.from;
    absl::string_view to = rule.to;
    for (const absl::string_view scheme : {"rostopic://", "rosservice://"}) {
      absl::ConsumePrefix(&from, scheme);
      absl::ConsumePrefix(&to, scheme);
    }
    const std::string text = absl::StrCat(rule.from, ":=", rule.to);
    RETURN_IF_ERROR(CheckName(text, from));
    RETURN_IF_ERROR(CheckName(text, to));
    names.remaps_.emplace_back(names.Expand(from), names.Expand(to));
  }
  return names;
}

std::string Ros2Names::full_name() const {
  return absl::StrCat(namespace_ == "/" ? "" : namespace_, "/", node_);
}

std::string Ros2Names::Expand(absl::string_view name) const {
  if (absl::StartsWith(name, "/")) return std::string(name);
  if (absl::ConsumePrefix(&name, "~/")) return absl::StrCat(full_name(), "/", name);
  return absl::StrCat(namespace_ == "/" ? "" : namespace_, "/", name);
}

std::string Ros2Names::Resolve(absl::string_view name) const {
  const std::string whole = Expand(name);
  for (const auto& [from, to] : remaps_) {
    if (from == whole) return to;
  }
  return whole;
}

std::string DdsTopic(absl::string_view topic) { return absl::StrCat(kTopicPrefix, topic); }
std::string DdsRequestTopic(absl::string_view service) {
  return absl::StrCat("rq", service, "Request");
}
std::string DdsResponseTopic(absl::string_view service) {
  return absl::StrCat("rr", service, "Reply");
}

std::string Ros2Topic(absl::string_view dds_topic) {
  return absl::StartsWith(dds_topic, "rt/") ? std::string(dds_topic.substr(kTopicPrefix.size()))
                                            : "";
}

std::string Ros2Type(absl::string_view dds_type) {
  if (!absl::StrContains(dds_type, "::dds_::")) return std::string(dds_type);
  return absl::StrReplaceAll(absl::StripSuffix(dds_type, "_"), {{"::dds_::", "/"}, {"::", "/"}});
}

}  // namespace corbslam::client_agent
