#include "services/tool/output/result.h"

#include <algorithm>
#include <atomic>
#include <cstdio>

#include "absl/strings/string_view.h"

namespace corbslam::services {
namespace {

std::atomic<bool> wants_json = false;

std::atomic<bool> prints_to_standard_error = false;

std::FILE* Output() { return prints_to_standard_error ? stderr : stdout; }

// Bytes that are no UTF-8, of a file's name say, are replaced.
std::string Dump(const nlohmann::ordered_json& document, int indent) {
  return document.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void AddJsonFlags(CLI::App& app) {
  const std::vector<CLI::App*> commands = app.get_subcommands(nullptr);
  for (CLI::App* command : commands) AddJsonFlags(*command);
  if (!commands.empty() || app.get_parent() == nullptr) return;
  if (app.get_option_no_throw("--json") == nullptr) {
    app.add_flag("--json")->description("Print JSON, for scripts");
  }
}

bool AsksForJson(const CLI::App& app) {
  const CLI::Option* option = app.get_option_no_throw("--json");
  if (option != nullptr && option->count() > 0) {
    return option->get_expected_min() == 0 ? option->as<bool>() : option->results().back() == "-";
  }
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  return std::any_of(parsed.begin(), parsed.end(),
                     [](const CLI::App* command) { return AsksForJson(*command); });
}

bool AsksForJson(int argc, const char* const* argv) {
  return std::find(argv, argv + argc, absl::string_view("--json")) != argv + argc;
}

void SetWantsJson(bool wants) { wants_json = wants; }
bool WantsJson() { return wants_json; }

void Say(const std::string& text) {
  if (wants_json) return;
  std::fputs(text.c_str(), Output());
  std::fflush(Output());
}

void PrintToStandardError() { prints_to_standard_error = true; }

void PrintResult(const std::string& text, const nlohmann::ordered_json& document) {
  std::fputs(wants_json ? (Dump(document, 2) + "\n").c_str() : text.c_str(), Output());
  std::fflush(Output());
}

nlohmann::ordered_json ErrorToJson(const absl::Status& error) {
  return {{"error",
           {{"code", absl::StatusCodeToString(error.code())},
            {"message", std::string(error.message())}}}};
}

void PrintError(const absl::Status& error, bool json) {
  const std::string line = json ? Dump(ErrorToJson(error), -1) : "corbslam: " + error.ToString();
  std::fprintf(stderr, "%s\n", line.c_str());
}

}  // namespace corbslam::services
