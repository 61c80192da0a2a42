// Makes a program's page for man from its flags.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_MAN_PAGE_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_MAN_PAGE_H_

#include <CLI/CLI.hpp>
#include <string>

namespace corbslam::services {

// Returns a page of section 1, for troff's man macros. Defaults that are paths are left out: they
// are this machine's.
std::string FormatManPage(const CLI::App& app, const std::string& environment_prefix,
                          const std::string& version);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_MAN_PAGE_H_
