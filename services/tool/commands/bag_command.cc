#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/bag_source.h"
#include "client_agent/source/bag/bag_summary.h"
#include "client_agent/source/source_spec.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::BagOptions;
using client_agent::BagSummary;
using client_agent::BagTopicSummary;
using client_agent::FindBag;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using client_agent::SummariseBag;

namespace {

nlohmann::ordered_json ToJson(const BagSummary& summary) {
  nlohmann::ordered_json topics = nlohmann::ordered_json::array();
  for (const BagTopicSummary& topic : summary.topics) {
    topics.push_back({{"topic", topic.name},
                      {"type", topic.type},
                      {"encoding", topic.encoding},
                      {"messages", topic.messages},
                      {"bytes", topic.bytes},
                      {"rate_hz", topic.rate_hz},
                      {"note", topic.note}});
  }
  nlohmann::ordered_json played = nlohmann::ordered_json::object();
  for (const auto& [name, value] : summary.played) played[name] = value;
  nlohmann::ordered_json findings = nlohmann::ordered_json::array();
  for (const client_agent::SourceFinding& finding : summary.findings) {
    findings.push_back({{"code", finding.code}, {"text", finding.text}});
  }
  return {{"format", summary.format},     {"files", summary.files},
          {"messages", summary.messages}, {"first_ns", summary.first_ns},
          {"last_ns", summary.last_ns},   {"topics", topics},
          {"notes", summary.notes},       {"played", played},
          {"findings", findings},         {"lacking", summary.lacking}};
}

absl::Status ShowBag(const std::string& bag) {
  const bool is_source = absl::StartsWith(bag, "bag:");
  ASSIGN_OR_RETURN(const SourceSpec spec, ParseSourceSpec(is_source ? bag : "bag:" + bag));
  const BagOptions* const options = FindBag(spec);
  if (options == nullptr) return absl::InvalidArgumentError(absl::StrCat(bag, ": is no bag"));
  ASSIGN_OR_RETURN(const BagSummary summary, SummariseBag(*options));
  PrintResult(FormatBagSummary(summary), ToJson(summary));
  return absl::OkStatus();
}

}  // namespace

void AddBagCommand(CLI::App& app, Command& chosen) {
  CLI::App* bag = app.add_subcommand("bag", "Look into ROS bags");
  bag->require_subcommand(1);
  auto path = std::make_shared<std::string>();
  CLI::App* info = bag->add_subcommand(
      "info", "List a bag's topics, and say what of it would be played, or what lacks");
  info->add_option("bag", *path, "A .bag, .db3 or .mcap file or rosbag2's folder, with ?OPTIONS")
      ->required();
  info->callback([path, &chosen] { chosen = [path] { return ShowBag(*path); }; });
}

}  // namespace corbslam::services
