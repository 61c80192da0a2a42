#include "tests/integration/include_rules.h"

#include <map>
#include <optional>
#include <set>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace corbslam::tests {
namespace {

using Folders = std::set<absl::string_view>;

// Top folders with the top folders that they may include, beside themselves.
const std::map<absl::string_view, Folders>& TopRules() {
  static const auto& rules = *new std::map<absl::string_view, Folders>{
      {"slam", {}},
      {"client_agent", {"slam"}},
      {"map_store", {"slam"}},
      {"fusion_worker", {"slam"}},
      {"services", {"slam", "client_agent", "map_store", "fusion_worker", "corbslam"}},
      {"tests", {"slam", "client_agent", "map_store", "fusion_worker", "services", "corbslam"}}};
  return rules;
}

using Heights = std::map<absl::string_view, int>;

// Height of each folder of a top folder. Each may include itself and what lies lower. A folder
// within a folder that has no height of its own belongs to the outer one.
const std::map<absl::string_view, Heights>& Ladders() {
  static const auto& ladders = *new std::map<absl::string_view, Heights>{
      {"slam",
       {
           {"util", 0},       {"geometry", 1},     {"camera", 2},   {"inertial", 2},
           {"evaluation", 3}, {"rendering", 3},    {"features", 3}, {"coding", 4},
           {"sensor", 4},     {"vocabulary", 4},   {"map", 5},      {"place", 6},
           {"matching", 6},   {"optimisation", 6}, {"solvers", 7},  {"exchange", 7},
           {"monocular", 8},  {"verification", 8}, {"fusing", 9},
       }},
      {"client_agent",
       {
           {"map", 0},
           {"push_client", 0},
           {"ros2", 0},
           {"source", 0},
           {"mapping", 1},
           {"shared", 1},
           {"spool", 0},
           {"upload", 1},
           {"far", 2},
           {"link", 2},
           {"source_checks", 1},
           {"live", 1},
           {"loop_closing", 2},
           {"tracking", 2},
           {"agent", 3},
       }},
      {"map_store",
       {
           {"fleet", 0},
           {"options", 0},
           {"state", 1},
           {"view", 2},
           {"ingest", 3},
           {"locating", 3},
           {"sharing", 3},
           {"fusion", 4},
           {"joining", 4},
           {"retiring", 4},
           {"records", 5},
           {"archive", 6},
           {"postgres", 7},
           {"rocks", 7},
           {"mission", 7},
           {"coordination", 8},
           {"process", 9},
           {"store", 10},
       }},
      {"services",
       {
           {"command_line", 0},
           {"convert", 0},
           {"observe", 0},
           {"observe/logging", 0},
           {"runtime", 0},
           {"convert/work", 1},
           {"client/reflection", 2},
           {"client/remote", 2},
           {"observe/adjustment_files", 2},
           {"server", 2},
           {"http", 3},
           {"agent_service", 3},
           {"fusion_worker_service", 3},
           {"map_store_service/streams", 3},
           {"map_store_service", 4},
           {"security", 5},
           {"client/reachability", 6},
           {"observe/event_log", 6},
           {"observe/metrics", 6},
           {"client/store", 7},
           {"programs/robot", 7},
           {"programs/recording", 7},
           {"tool/export", 8},
           {"tool/output", 8},
           {"viewer", 8},
           {"programs", 9},
           {"ros2", 10},
           {"simulation", 9},
           {"simulated_source", 10},
           {"tool/doctor", 10},
           {"tool/mission", 10},
           {"tool/report", 10},
           {"tool/rig", 10},
           {"tool/evaluation", 11},
           {"tool/replay", 12},
           {"tool/run", 12},
           {"tool/sequence", 12},
           {"tool/commands", 13},
       }},
  };
  return ladders;
}

absl::string_view Part(absl::string_view path, size_t index) {
  const std::vector<absl::string_view> parts = absl::StrSplit(path, '/');
  return index + 1 < parts.size() ? parts[index] : absl::string_view();
}

// Returns the entry of `heights` for a file: that of the innermost folder that has one.
Heights::const_iterator FindRoom(const Heights& heights, absl::string_view path) {
  const std::vector<absl::string_view> parts = absl::StrSplit(path, '/');
  if (parts.size() < 3) return heights.end();
  if (parts.size() > 3) {
    const std::string inner = absl::StrCat(parts[1], "/", parts[2]);
    if (const auto room = heights.find(inner); room != heights.end()) return room;
  }
  return heights.find(parts[1]);
}

// Returns the text between quotes or angle brackets of an #include line.
std::optional<absl::string_view> ParseInclude(absl::string_view line) {
  absl::string_view rest = absl::StripLeadingAsciiWhitespace(line);
  if (!absl::ConsumePrefix(&rest, "#include")) return std::nullopt;
  rest = absl::StripAsciiWhitespace(rest);
  if (rest.size() < 2) return std::nullopt;
  const size_t end = rest.find_first_of("\">", 1);
  return rest.substr(1, end - 1);
}

bool IsWire(absl::string_view include) {
  return absl::StartsWith(include, "grpc") || absl::StartsWith(include, "google/protobuf/") ||
         absl::EndsWith(include, ".pb.h");
}

bool IsTestCode(absl::string_view path) {
  return absl::EndsWith(path, "_test.cc") || absl::EndsWith(path, "_benchmark.cc") ||
         absl::StrContains(path, "/testing/");
}

// Returns why the include is not allowed; empty where it is.
std::string WhyNot(absl::string_view path, absl::string_view include) {
  const absl::string_view top = Part(path, 0);
  const bool is_anothers =
      absl::StrContains(path, "/examples/");  // A program of whoever uses ours.
  if (IsWire(include) && top != "services" && top != "tests" && !is_anothers) {
    return "only services/ knows gRPC and protobuf";
  }
  if (absl::StartsWith(include, "prometheus/") && top != "services") {
    return "only services/ knows Prometheus";
  }
  if (absl::StartsWith(path, "services/simulation/") && absl::StartsWith(include, "services/") &&
      !absl::StartsWith(include, "services/simulation/")) {
    return "the simulator stands on slam/ alone";
  }
  const absl::string_view target = Part(include, 0);
  if (!TopRules().contains(target) || IsWire(include)) return "";  // Such a file is not ours.
  if (target != top && !TopRules().at(top).contains(target)) {
    return absl::StrCat(top, "/ may not include ", target, "/");
  }
  const auto ladder = Ladders().find(top);
  if (target != top || ladder == Ladders().end() || IsTestCode(path)) return "";
  const auto from = FindRoom(ladder->second, path);
  const auto to = FindRoom(ladder->second, include);
  if (from == ladder->second.end() || to == ladder->second.end()) {
    return absl::StrCat("a part of ", top, "/ that include_rules.cc does not know");
  }
  if (from->first == to->first || to->second < from->second) return "";
  return absl::StrCat(top, "/", to->first, " does not lie below ", top, "/", from->first);
}

}  // namespace

std::vector<std::string> FindForbiddenIncludes(absl::string_view path, absl::string_view text) {
  std::vector<std::string> forbidden;
  if (!TopRules().contains(Part(path, 0))) return forbidden;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    const std::optional<absl::string_view> include = ParseInclude(line);
    if (!include.has_value()) continue;
    const std::string why = WhyNot(path, *include);
    if (why.empty()) continue;
    forbidden.push_back(absl::StrCat(path, ":", number, ": includes ", *include, ": ", why));
  }
  return forbidden;
}

}  // namespace corbslam::tests
