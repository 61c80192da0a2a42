#include "services/tool/evaluation/report_detail.h"

#include <algorithm>
#include <utility>

#include "services/tool/evaluation/held_picture.h"
#include "services/tool/evaluation/picture.h"
#include "services/tool/evaluation/trajectory_files.h"
#include "services/tool/report/html/long_interval.h"

namespace corbslam::services {
namespace {

// Frames further apart than this had lost ones between them.
double LongestGap_s(const std::vector<TrajectoryPart>& parts) {
  std::vector<double> intervals_s;
  for (const TrajectoryPart& part : parts) {
    for (size_t i = 1; i < part.poses.size(); ++i) {
      intervals_s.push_back(
          1e-9 * static_cast<double>(part.poses[i].timestamp_ns - part.poses[i - 1].timestamp_ns));
    }
  }
  return LongInterval_s(std::move(intervals_s));
}

// Adds the stretches of one local map, and when it began unless it is the first.
void AddTracked(const TrajectoryPart& part, int64_t begin_ns, double gap_s,
                ReportDetail::Robot& detail) {
  const auto at_s = [&](size_t i) {
    return 1e-9 * static_cast<double>(part.poses[i].timestamp_ns - begin_ns);
  };
  for (size_t i = 0; i < part.poses.size(); ++i) {
    const bool goes_on = i > 0 && at_s(i) - at_s(i - 1) <= gap_s;
    if (!goes_on) detail.tracked.push_back({at_s(i), at_s(i)});
    detail.tracked.back().end_s = at_s(i);
  }
}

void AddTimes(const ServedTrajectory& local, ReportDetail::Robot& detail) {
  const std::vector<TrajectoryPart> parts = PartsOf(local);
  if (parts.empty()) return;
  const int64_t begin_ns = parts.front().poses.front().timestamp_ns;
  detail.begin_ns = begin_ns;
  const double gap_s = LongestGap_s(parts);
  for (const TrajectoryPart& part : parts) {
    AddTracked(part, begin_ns, gap_s, detail);
    if (&part == &parts.front()) continue;
    detail.local_maps_s.push_back(1e-9 *
                                  static_cast<double>(part.poses.front().timestamp_ns - begin_ns));
  }
}

}  // namespace

ReportDetail ComposeDetail(const std::vector<RobotPaths>& robots, const ServedMap& map,
                           const std::string& own, const Accuracy& accuracy) {
  ReportDetail detail;
  for (size_t i = 0; i < robots.size(); ++i) {
    ReportDetail::Robot& robot = detail.robots.emplace_back();
    robot.name = robots[i].name;
    AddTimes(robots[i].local, robot);
    if (i >= accuracy.robots.size()) continue;
    robot.errors = accuracy.robots[i].profile;
    if (robot.tracked.empty() && !robot.errors.empty()) {
      robot.begin_ns = robot.errors.front().timestamp_ns;
    }
    robot.errors_are_global = accuracy.robots[i].is_profile_global;
    robot.by_length = accuracy.robots[i].by_length;
  }
  detail.map = ComposePicture(map, own, accuracy.fused, DrivenOf(robots));
  return detail;
}

std::vector<ReportDetail::Held> ComposeHeld(
    const std::vector<RobotPaths>& robots,
    const std::vector<std::optional<client_agent::NearMap>>& held, const ServedMap& map) {
  std::vector<ReportDetail::Held> pictures;
  for (size_t i = 0; i < std::min(robots.size(), held.size()); ++i) {
    if (!held[i].has_value() || held[i]->keyframes.empty()) continue;
    ReportDetail::Held& picture = pictures.emplace_back();
    picture.robot = robots[i].name;
    picture.map = ComposeHeldPicture(robots[i].name, *held[i], map);
    picture.nearer = CutMeeting(picture.map);
  }
  return pictures;
}

}  // namespace corbslam::services
