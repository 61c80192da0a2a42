#include "tests/integration/grpcurl_page.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {
namespace {

// Returns the texts between lines of three backquotes.
std::vector<std::string> ReadBlocks(const std::string& markdown) {
  std::vector<std::string> blocks;
  bool inside = false;
  for (const absl::string_view line : absl::StrSplit(markdown, '\n')) {
    if (absl::StartsWith(line, "```")) {
      inside = !inside;
      if (inside) blocks.emplace_back();
    } else if (inside) {
      absl::StrAppend(&blocks.back(), line, "\n");
    }
  }
  return blocks;
}

// Splits a line as a shell does; single quotes only.
std::vector<std::string> SplitArguments(const std::string& line) {
  std::vector<std::string> arguments;
  bool quoted = false;
  bool begun = false;
  for (const char c : line) {
    if (c == '\'') quoted = !quoted;
    const bool between = !quoted && (c == ' ' || c == '\n');
    if (!between && !begun) arguments.emplace_back();
    if (!between && c != '\'') arguments.back().push_back(c);
    begun = !between;
  }
  return arguments;
}

absl::StatusOr<GrpcurlCall> ParseCall(const std::string& line) {
  GrpcurlCall call;
  call.line = line;
  std::vector<std::string> rest;
  const std::vector<std::string> arguments = SplitArguments(line);
  for (size_t i = 1; i < arguments.size(); ++i) {
    if (arguments[i] == "-plaintext") continue;
    const bool has_value = i + 1 < arguments.size();
    if (arguments[i] == "-d" && has_value) {
      call.request = arguments[++i];
    } else if (arguments[i] == "-max-time" && has_value) {
      if (!absl::SimpleAtod(arguments[++i], &call.max_time_s)) break;
    } else {
      rest.push_back(arguments[i]);
    }
  }
  if (rest.size() < 2) return absl::InvalidArgumentError(absl::StrCat("not a call: ", line));
  call.address = rest[0];
  call.is_list = rest[1] == "list";
  call.target = call.is_list ? (rest.size() > 2 ? rest[2] : "") : rest[1];
  return call;
}

void AddPaths(const nlohmann::json& value, const std::string& path, std::set<std::string>& paths) {
  if (value.is_array()) {
    for (const nlohmann::json& element : value) AddPaths(element, path + "[]", paths);
  } else if (value.is_object()) {
    for (const auto& [name, field] : value.items()) {
      const std::string below = absl::StrCat(path, path.empty() ? "" : ".", name);
      paths.insert(below);
      AddPaths(field, below, paths);
    }
  }
}

}  // namespace

absl::StatusOr<std::vector<GrpcurlCall>> ReadGrpcurlCalls(const std::string& markdown) {
  const std::vector<std::string> blocks = ReadBlocks(markdown);
  std::vector<GrpcurlCall> calls;
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (!absl::StartsWith(blocks[i], "grpcurl ")) continue;
    ASSIGN_OR_RETURN(GrpcurlCall call, ParseCall(blocks[i]));
    if (i + 1 == blocks.size() || absl::StartsWith(blocks[i + 1], "grpcurl ")) {
      return absl::InvalidArgumentError(absl::StrCat("without an answer: ", blocks[i]));
    }
    call.answer = blocks[i + 1];
    calls.push_back(std::move(call));
  }
  return calls;
}

absl::StatusOr<std::vector<nlohmann::json>> ParseDocuments(absl::string_view text) {
  std::vector<nlohmann::json> documents;
  std::string pending;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    absl::StrAppend(&pending, line, "\n");
    // Only a document's own end stands at the beginning of a line.
    if (line != "}" && line != "{}") continue;
    nlohmann::json document = nlohmann::json::parse(pending, nullptr, false);
    if (document.is_discarded()) {
      return absl::InvalidArgumentError(absl::StrCat("not JSON: ", pending));
    }
    documents.push_back(std::move(document));
    pending.clear();
  }
  return documents;
}

std::set<std::string> FieldPaths(const std::vector<nlohmann::json>& documents) {
  std::set<std::string> paths;
  for (const nlohmann::json& document : documents) AddPaths(document, "", paths);
  return paths;
}

}  // namespace corbslam::tests
