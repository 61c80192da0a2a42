// Holds what a run measured. As JSON it is a stable interface: docs/report.md says what each field
// is.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_REPORT_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_REPORT_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "services/programs/robot/robot_report.h"

namespace corbslam::services {

struct FusedReport {
  int islands = 0;
  int robots = 0;  // Robots of which something lies in the global frame.
  uint64_t keyframes = 0;
  uint64_t map_points = 0;
  std::optional<double> ate_m;
  std::optional<double> ate_from_frame_m;
  std::optional<double> ate_without_scale_m;
  std::optional<double> scale;  // Scale of that similarity, truth by estimate.
  std::optional<double> t_rel_percent;
  std::optional<double> r_rel_deg_per_100m;
};

struct OverlapReport {
  uint64_t queried = 0;
  uint64_t verified = 0;
  uint64_t accepted = 0;
};

struct AdjustmentReport {
  uint64_t keyframes = 0;
  uint64_t map_points = 0;
  uint64_t iterations = 0;
  double ms = 0;
};

struct TransferReport {
  uint64_t count = 0;
  uint64_t bytes = 0;
  double ms = 0;
};

struct ServerReport {
  double peak_rss_mb = 0;
  double cpu_s = 0;
};

// What the same robots measured when they were told nothing of what others made.
struct CompanyReport {
  // In the order of the run's robots. What was told counts over the frames that the robot in
  // company told in the global frame, and before.
  std::vector<RobotReport> alone;
  std::optional<double> fused_ate_alone_m;
  double wall_s = 0;
};

struct RunReport {
  std::string mission;
  std::string pace;
  size_t from_frame = 0;  // The frame from which the ..._from_frame values count.
  std::vector<RobotReport> robots;
  std::vector<ReportWarning> warnings;  // Warnings of the run, beside those of the robots.
  FusedReport fused;
  OverlapReport overlaps;
  std::vector<double> merge_ms;
  std::vector<AdjustmentReport> global_ba_ms;
  TransferReport full_keyframes;
  TransferReport full_map_points;
  TransferReport light_keyframes;
  TransferReport light_map_points;
  std::map<std::string, ServerReport> servers;
  std::optional<CompanyReport> company;  // Set if the robots played a second time, alone.
  double wall_s = 0;
  std::string version;
  std::string command;
};

// Returns the robots' warnings in their order, then the run's.
std::vector<ReportWarning> AllWarnings(const RunReport& report);

nlohmann::ordered_json ToJson(const RunReport& report);
// Writes tables for people.
std::string ToMarkdown(const RunReport& report);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_REPORT_H_
