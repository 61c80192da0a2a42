// Says what to do about a folder that isn't of the layout that it was said to be.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LAYOUT_HINTS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LAYOUT_HINTS_H_

#include "absl/status/status.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {

// Adds to `error`, met when the recorded sequence `spec` was opened, what its folder looks like:
// that it is not there, that it looks like another layout's, or that a folder in it looks like this
// layout's. Returns `error` as it was if the folder looks as it should, or like nothing known.
absl::Status WithLayoutHint(const absl::Status& error, const SourceSpec& spec);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LAYOUT_HINTS_H_
