// Makes completion scripts for shells from a program's flags.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_COMPLETION_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_COMPLETION_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace corbslam::services {

// Returns the values of an option that takes one of a few; empty for all others.
std::vector<std::string> Choices(const CLI::Option& option);

// Returns a script to be sourced by bash. It completes commands, flags, and values where there are
// few; else names of files.
std::string BashCompletion(const CLI::App& app);
// Returns a file of zsh's $fpath, _PROGRAM: the same function, by zsh's bashcompinit.
std::string ZshCompletion(const CLI::App& app);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_COMPLETION_H_
