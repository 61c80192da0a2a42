// Holds every program's flags to what a value may be, wherever it was given: on the command line,
// in the environment or in the file of --config.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_VALUES_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_VALUES_H_

#include <CLI/CLI.hpp>
#include <string>

namespace corbslam::services {

// Has every option of the app and its commands refuse what is none of its values: an empty text
// (in a script it is a variable that is not set), a number with something before or behind it, with
// digits that C reads as octal, below 0, not finite, or with more digits than there is room for;
// and for a switch all but true and false. The app must have all of its options.
void CheckEveryValue(CLI::App& app);

// Returns what CLI11 says of a value that is out of range, none of some choices or no number, in
// the terms of our flags; other messages as they are.
std::string Rephrased(const std::string& message);

// Lets an option be given an empty text: one that takes back what was set.
CLI::Option* MayBeEmpty(CLI::Option* option);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_VALUES_H_
