#include "services/ros2/ros2_diagnosis.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "services/agent_service/posted_pose.h"
#include "slam/util/ids.h"

namespace corbslam::services {

using client_agent::TrackingState;
using Level = Ros2Diagnosis::Level;

namespace {

// Further from the time by ROS another clock stamps the pictures.
constexpr double kOtherClock_s = 5;

Ros2Diagnosis OfTracking(const Ros2Facts& facts) {
  Ros2Diagnosis line{Level::kOk, "tracking", "tracking", {}};
  const client_agent::AgentStatus& agent = facts.agent;
  if (!facts.has_begun) {
    line.level = Level::kStale;
    line.message = "waits for the camera";
  } else if (facts.has_ended) {
    line.level = Level::kStale;
    line.message = "no frame comes any more";
  } else if (facts.silence != Silence::kNone) {
    line.level = Level::kError;
    line.message = Describe(facts.silence, facts.silent_for_s, facts.image_topics);
  } else if (agent.frames == 0) {
    line.level = Level::kWarning;
    line.message = "no frame was tracked yet";
  } else if (agent.state != TrackingState::kTracking) {
    line.level = Level::kWarning;
    line.message = absl::StrCat(agent.state == TrackingState::kLost ? "lost: " : "no map yet: ",
                                v1::WhyNoPose_Name(ToProto(agent.why_no_pose)));
  }
  line.values = {{"local_map", ToString(agent.local_map)},
                 {"global_frame", agent.global_from_local.has_value() ? "known" : "not known"},
                 {"keyframes", absl::StrCat(agent.keyframes)},
                 {"map_points", absl::StrCat(agent.map_points)},
                 {"frames", absl::StrCat(agent.frames)},
                 {"frames_lost", absl::StrCat(agent.lost)},
                 {"frames_dropped", absl::StrCat(facts.dropped)},
                 {"loops_closed", absl::StrCat(agent.loops_closed)},
                 {"mapping", agent.mapping_paused ? "paused" : "on"}};
  if (facts.latency_ms.has_value()) {
    line.values.emplace_back("picture_to_pose_ms", absl::StrFormat("%.1f", *facts.latency_ms));
  }
  return line;
}

Ros2Diagnosis OfCamera(const Ros2Facts& facts) {
  Ros2Diagnosis line{Level::kOk, "camera", "pictures come", {}};
  if (!facts.waits_for.empty()) {
    line.level = facts.has_begun ? Level::kWarning : Level::kError;
    line.message = facts.waits_for;
  }
  const std::optional<double>& ahead_s = facts.stamp_ahead_s;
  if (facts.has_begun && ahead_s.has_value() && std::abs(*ahead_s) > kOtherClock_s) {
    line.level = Level::kWarning;
    line.message = absl::StrFormat(
        "pictures are stamped %.1f s %s the time by ROS: %s", std::abs(*ahead_s),
        *ahead_s > 0 ? "after" : "before",
        facts.use_sim_time ? "are they of what /clock is of?"
                           : "where a recording is played, say use_sim_time:=true and play /clock");
  }
  for (const size_t side : {size_t{0}, size_t{1}}) {
    line.values.emplace_back(facts.image_topics[side], absl::StrCat(facts.flow.pictures[side]));
  }
  return line;
}

Ros2Diagnosis OfStore(const absl::Status& session) {
  if (session.ok()) return {Level::kOk, "map store", "connected", {}};
  return {Level::kWarning, "map store", std::string(session.message()), {}};
}

Ros2Diagnosis OfTransforms(const Ros2Facts& facts) {
  Ros2Diagnosis line{Level::kOk, "transforms", "published", {}};
  if (!facts.conflicts.empty()) {
    line.level = Level::kError;
    line.message = absl::StrCat(
        "somebody else publishes ", absl::StrJoin(facts.conflicts, " and "),
        ", too: turn one of the two off (publish_odom_to_base_tf, publish_map_to_odom_tf); where "
        "it is "
        "another robot, give each a tree of its own (-r /tf:=tf) or frames of its own");
  } else if (facts.unmatched > 0) {
    line.level = Level::kWarning;
    line.message = absl::StrCat("map -> odom is missing for ", facts.unmatched,
                                " frames: /tf has no odom -> base around their time, which "
                                "publish_odom_to_base_tf:=false leaves to somebody else");
  } else if (!facts.session.has_value() && facts.agent.local_maps > 1) {
    line.level = Level::kWarning;
    line.message = absl::StrCat("this is local map ", facts.agent.local_maps,
                                ": without a map store the map's frame is another one than before");
  }
  return line;
}

}  // namespace

std::string Describe(Silence silence, double silent_for_s, const std::string (&topics)[2]) {
  const std::string since = absl::StrFormat(" for %.1f s", silent_for_s);
  switch (silence) {
    case Silence::kNone:
      return "";
    case Silence::kNoPictures:
      return absl::StrCat("no picture came", since, ": does the driver run?");
    case Silence::kFirstGone:
      return absl::StrCat("no picture of ", topics[0], " came", since, ", though those of ",
                          topics[1], " do");
    case Silence::kSecondGone:
      return absl::StrCat("no picture of ", topics[1], " came", since, ", though those of ",
                          topics[0], " do");
    case Silence::kNoFrames:
      return absl::StrCat("pictures of both sides come, and no two were of one time", since,
                          " (sync_matching_threshold_ms)");
    case Silence::kNoPoses:
      return absl::StrCat("pictures come, and no pose went out", since);
  }
  return "";
}

std::vector<Ros2Diagnosis> Diagnose(const Ros2Facts& facts) {
  std::vector<Ros2Diagnosis> lines = {OfTracking(facts), OfCamera(facts), OfTransforms(facts)};
  if (facts.session.has_value()) lines.push_back(OfStore(*facts.session));
  return lines;
}

}  // namespace corbslam::services
