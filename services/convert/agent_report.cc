#include "services/convert/agent_report.h"

#include <cmath>
#include <limits>

#include "services/convert/errors.h"
#include "services/convert/limits.h"

namespace corbslam::services {
namespace {

AgentActivity ReadActivity(int activity) {
  switch (activity) {
    case v1::AGENT_ACTIVITY_INITIALISING:
      return AgentActivity::kInitialising;
    case v1::AGENT_ACTIVITY_TRACKING:
      return AgentActivity::kTracking;
    case v1::AGENT_ACTIVITY_LOST:
      return AgentActivity::kLost;
    case v1::AGENT_ACTIVITY_WAITING:
      return AgentActivity::kWaiting;
    case v1::AGENT_ACTIVITY_FINISHED:
      return AgentActivity::kFinished;
    default:
      return AgentActivity::kUnknown;
  }
}

}  // namespace

v1::AgentActivity ToProto(AgentActivity activity) {
  switch (activity) {
    case AgentActivity::kInitialising:
      return v1::AGENT_ACTIVITY_INITIALISING;
    case AgentActivity::kTracking:
      return v1::AGENT_ACTIVITY_TRACKING;
    case AgentActivity::kLost:
      return v1::AGENT_ACTIVITY_LOST;
    case AgentActivity::kWaiting:
      return v1::AGENT_ACTIVITY_WAITING;
    case AgentActivity::kFinished:
      return v1::AGENT_ACTIVITY_FINISHED;
    case AgentActivity::kUnknown:
      break;
  }
  return v1::AGENT_ACTIVITY_UNSPECIFIED;
}

void ToProto(const AgentReport& report, v1::AgentReport* proto) {
  proto->set_activity(ToProto(report.activity));
  proto->set_frames(report.frames);
  proto->set_tracked(report.tracked);
  proto->set_lost(report.lost);
  proto->set_dropped(report.dropped);
  proto->set_newest_timestamp_ns(report.newest_timestamp_ns);
  proto->set_newest_frame_age_s(report.newest_frame_age_s);
}

absl::StatusOr<AgentReport> FromProto(const v1::AgentReport& proto) {
  const int64_t newest_ns = proto.newest_timestamp_ns();
  if (newest_ns < 0 || newest_ns > kMaxTimestamp_ns) {
    return OutOfRange("report.newest_timestamp_ns", newest_ns, int64_t{0}, kMaxTimestamp_ns);
  }
  const double age_s = proto.newest_frame_age_s();
  // The condition is written so that NaN is refused.
  if (!(age_s >= 0 && std::isfinite(age_s))) {
    return OutOfRange("report.newest_frame_age_s", age_s, 0.0, std::numeric_limits<double>::max());
  }
  return AgentReport{.activity = ReadActivity(proto.activity()),
                     .frames = proto.frames(),
                     .tracked = proto.tracked(),
                     .lost = proto.lost(),
                     .dropped = proto.dropped(),
                     .newest_timestamp_ns = newest_ns,
                     .newest_frame_age_s = age_s};
}

}  // namespace corbslam::services
