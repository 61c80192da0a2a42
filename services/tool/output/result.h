// Prints what a command of the tool found out: text for people, or with --json one document; and
// how it failed.
#ifndef CORBSLAM_SERVICES_TOOL_OUTPUT_RESULT_H_
#define CORBSLAM_SERVICES_TOOL_OUTPUT_RESULT_H_

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/status/status.h"

namespace corbslam::services {

// Adds --json to each command below `app` that has no further ones and no such flag.
void AddJsonFlags(CLI::App& app);
// Returns whether the command that was parsed has --json set ("-" where it takes a file).
bool AsksForJson(const CLI::App& app);
// The same for arguments that could not be parsed.
bool AsksForJson(int argc, const char* const* argv);

// Says for this process what AsksForJson returned. It is set once, before the command runs.
void SetWantsJson(bool wants);
bool WantsJson();

// Prints text that is for people only: nothing with --json.
void Say(const std::string& text);
// Has what is printed go to standard error: standard output has a result of its own.
void PrintToStandardError();
// Prints the text, or with --json the document.
void PrintResult(const std::string& text, const nlohmann::ordered_json& document);

// Returns {"error": {"code": "NOT_FOUND", "message": ...}}.
nlohmann::ordered_json ErrorToJson(const absl::Status& error);
// Prints on standard error "corbslam: CODE: MESSAGE", or with `json` the document above in a line.
void PrintError(const absl::Status& error, bool json);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_OUTPUT_RESULT_H_
