// Opens a sequence the way every program does: described, looked into, and refused where nothing
// right can come of it.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_INSPECTED_SOURCE_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_INSPECTED_SOURCE_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/recorded_sequence.h"
#include "client_agent/source/source_description.h"
#include "client_agent/source/source_finding.h"

namespace corbslam {

struct InspectedSource {
  std::unique_ptr<RecordedSequence> source;
  SourceDescription description;
  SourceFindings warnings;  // Of opening it and of a sample of its frames.
};

// INVALID_ARGUMENT with every error that was found, or with every warning too when `strict`.
absl::StatusOr<InspectedSource> OpenInspectedSource(const SourceSpec& spec, bool strict);

// OK where `findings` holds no error (and no warning, when `strict`).
absl::Status JudgeFindings(const SourceFindings& findings, bool strict);

// A line for each part of the description, indented.
std::string FormatDescription(const SourceDescription& description);

// Logs the description, a line each, and the warnings as such.
void LogSource(const InspectedSource& source);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_INSPECTED_SOURCE_H_
