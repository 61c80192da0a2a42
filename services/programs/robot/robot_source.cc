#include "services/programs/robot/robot_source.h"

#include <glog/logging.h>

#include <memory>
#include <utility>

#include "client_agent/source/live_opening.h"
#include "client_agent/source_checks/judged_stream.h"
#include "services/programs/robot/inspected_source.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::CheckLiveSource;
using client_agent::IsLive;
using client_agent::JudgedStream;
using client_agent::JudgedStreamOptions;
using client_agent::LiveSource;
using client_agent::OpenLiveSource;
using client_agent::SourceFinding;
using client_agent::SourceSpec;

absl::StatusOr<RobotSource> OpenRobotSource(const SourceSpec& spec, bool strict,
                                            const absl::Notification& stop) {
  if (IsLive(spec)) {
    ASSIGN_OR_RETURN(LiveSource camera, OpenLiveSource(spec, stop));
    RETURN_IF_ERROR(JudgeFindings(camera.stream->findings(), strict));
    const JudgedStreamOptions options{.trust_calibration = spec.settings->trusts_calibration(),
                                      .strict = strict};
    auto judged = std::make_unique<JudgedStream>(std::move(camera.stream), options);
    return RobotSource{std::move(judged), std::move(camera.description), {}};
  }
  ASSIGN_OR_RETURN(InspectedSource inspected, OpenInspectedSource(spec, strict));
  return RobotSource{std::move(inspected.source), std::move(inspected.description),
                     std::move(inspected.warnings)};
}

absl::Status CheckRobotSource(const SourceSpec& spec, bool strict) {
  return IsLive(spec) ? CheckLiveSource(spec) : OpenInspectedSource(spec, strict).status();
}

void LogSource(const RobotSource& source) {
  LOG(INFO) << "the source:\n" << FormatDescription(source.description);
  for (const SourceFinding& warning : source.warnings) {
    LOG(WARNING) << warning.text << " [" << warning.code << "]";
  }
}

}  // namespace corbslam::services
