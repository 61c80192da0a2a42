// Checks a source's calibration against its own pictures, for `corbslam rig check`.
#ifndef CORBSLAM_SERVICES_TOOL_RIG_RIG_CHECK_H_
#define CORBSLAM_SERVICES_TOOL_RIG_RIG_CHECK_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_finding.h"
#include "services/tool/rig/pair_regions.h"

namespace corbslam::services {

struct RigCheck {
  // What is known of the source and its camera: a name and a value for each line.
  std::vector<std::pair<std::string, std::string>> description;
  client_agent::SourceFindings findings;
  std::optional<PairRegions> regions;  // Stereo only.
  // Rectified pictures of a pair, or the grey picture and its depth, as the system sees them, with
  // rows drawn through both and matches: green where rows agree, red where they don't.
  cv::Mat picture;

  // Returns true if nothing that was found is an error.
  bool IsUsable() const;
};

// Looks at a sample of the frames that `spec` selects. INVALID_ARGUMENT where the calibration is
// impossible.
absl::StatusOr<RigCheck> CheckRig(const client_agent::FrameReader& reader,
                                  const client_agent::SourceSpec& spec);

// Takes frames of a live camera for `duration`; the report also says how the frames came.
// UNAVAILABLE without a frame; else as the camera's own error says it.
absl::StatusOr<RigCheck> CheckLiveRig(client_agent::FrameStream& stream,
                                      const client_agent::SourceDescription& description,
                                      absl::Duration duration);

// Returns what was found, for people: lines, a table of rows by region, findings, and a last
// sentence that says whether the rig is right.
std::string FormatRigCheck(const RigCheck& check);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RIG_RIG_CHECK_H_
