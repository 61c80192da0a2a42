// Holds what a robot's run measured: the robot writes it (client_agent --stats), the tool reads it,
// adds what only the tool knows, and puts it into report.json. docs/report.md says what each field
// is.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_ROBOT_REPORT_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_ROBOT_REPORT_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/upload/held_back.h"
#include "slam/util/bounded_sample.h"

namespace corbslam::services {

struct Spread {
  double median = 0;
  double mean = 0;
  double p99 = 0;

  bool operator==(const Spread&) const = default;
};
// Returns zeros if there are no values.
Spread ComputeSpread(std::vector<double> values);
// Returns that of all values' mean and of the kept ones' percentiles.
Spread SpreadOf(const BoundedSample& sample);

// Says that something looks wrong; docs/sources.md lists the codes.
struct ReportWarning {
  // Empty: the warning is of the run as a whole, or of the robot whose report it is in.
  std::string robot;
  std::string code;
  std::string text;

  bool operator==(const ReportWarning&) const = default;
};

// Counts what had not reached the store when the robot ended, and what could not.
struct OutboxReport {
  uint64_t batches = 0;
  uint64_t memory_bytes = 0;
  uint64_t spool_bytes = 0;
  uint64_t spool_syncs = 0;  // How often the disk was made to keep what the spool had.
  int lost_local_maps = 0;
  uint64_t refused_items = 0;  // Items with impossible values, which were in no batch.

  bool operator==(const OutboxReport&) const = default;
};

// Holds a robot's measurements. Nullopt means that the value could not be measured; a robot cannot
// know how accurate it is.
struct RobotReport {
  std::string name;
  std::string source;
  // What of the map store's settings for robots it took and refused; null: it took none at all.
  nlohmann::ordered_json settings;
  // What the robot knew of its source (services/programs/robot/source_json.h); null if it didn't
  // get as far.
  nlohmann::ordered_json source_description;
  std::vector<ReportWarning> warnings;
  int frames = 0;
  int tracked = 0;
  int dropped = 0;
  int lost = 0;
  int left_out = 0;       // Frames that could not be read.
  double pictures_s = 0;  // Seconds that its camera took for `frames`.
  int local_maps = 0;
  int hand_overs = 0;
  // Without a map store: keyframes that came back after they had left memory, as often as they did;
  // places recognised for that; local maps that could not be read.
  uint64_t brought_back = 0;
  uint64_t far_recognised = 0;
  uint64_t far_unreadable = 0;
  // Seconds of frames after which the local map of an earlier process went on.
  std::optional<double> resumed_after_s;
  std::string why_not_resumed;  // Empty: it was, or there was none.
  double map_mb = 0;  // About what the last local map took in memory, in units of 2^20 bytes.
  std::optional<double> first_upload_s;
  int keyframes_held = 0;
  double points_matched_percent = 0;
  int shared_loops_closed = 0;
  int places_told = 0;
  std::optional<double> located_after_s;
  int shared_relocalised = 0;  // Of `relocalised`, by points most of which others made.
  int loops_closed = 0;
  int relocalised = 0;
  int keyframes = 0;
  int map_points = 0;
  std::optional<double> ate_m;
  std::optional<double> ate_from_frame_m;
  std::optional<double> ate_global_m;
  // Of the poses that the robot told when each frame came (services/programs/robot/told_poses.h).
  std::optional<double> told_ate_m;
  std::optional<double> told_ate_before_m;
  uint64_t told_jumps = 0;
  double told_jumps_m = 0;
  double told_largest_jump_m = 0;
  std::optional<double> t_rel_percent;
  std::optional<double> r_rel_deg_per_100m;
  Spread tracking_ms;
  Spread latency_ms;  // Zeros for recordings.
  Spread local_ba_ms;
  int local_ba_count = 0;
  std::optional<double> peak_rss_mb;
  std::optional<double> cpu_s;
  OutboxReport outbox;
  client_agent::UpdateCounts held_back = {};  // Items that were in no batch yet.
  uint64_t bytes_up = 0;
  uint64_t bytes_down = 0;

  bool operator==(const RobotReport&) const = default;
};

// Returns the report without what only the player of the pictures knows: name, source and its
// description, dropped, unread and relocalised frames, the pictures' time, warnings, bytes, memory,
// processor time and accuracy.
RobotReport MakeRobotReport(const client_agent::Agent& agent);

// Returns the findings in the form that reports have.
std::vector<ReportWarning> ToReportWarnings(const client_agent::SourceFindings& findings);

// Returns the line with which a robot ends: what it tracked and mapped, and what did not get to the
// store.
std::string DescribeEnd(const RobotReport& report);

// Writes the report. The names of the fields are a stable interface.
nlohmann::ordered_json ToJson(const RobotReport& report);
// Reads a report. DATA_LOSS names the field that is missing, of another kind or out of range.
absl::StatusOr<RobotReport> RobotReportFromJson(const nlohmann::ordered_json& json);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_ROBOT_REPORT_H_
