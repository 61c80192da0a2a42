// Opens a sequence the way every program does: it is described, checked, and refused if nothing
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

namespace corbslam::services {

struct InspectedSource {
  std::unique_ptr<client_agent::RecordedSequence> source;
  client_agent::SourceDescription description;
  client_agent::SourceFindings
      warnings;  // Warnings from opening it and from a sample of its frames.
};

// Returns INVALID_ARGUMENT with every error that was found, and with every warning too if `strict`.
absl::StatusOr<InspectedSource> OpenInspectedSource(const client_agent::SourceSpec& spec,
                                                    bool strict);

// Returns OK if `findings` holds no error (and no warning, if `strict`).
absl::Status JudgeFindings(const client_agent::SourceFindings& findings, bool strict);

// Returns a line for each part of the description, indented.
std::string FormatDescription(const client_agent::SourceDescription& description);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_INSPECTED_SOURCE_H_
