#include "slam/evaluation/trajectory_io.h"

#include <optional>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "slam/evaluation/pose_header.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

absl::StatusOr<std::optional<int64_t>> ParseNanoseconds(absl::string_view field, double number,
                                                        const std::string& path, int line) {
  int64_t nanoseconds = 0;
  if (absl::SimpleAtoi(field, &nanoseconds)) return nanoseconds;
  if (!AllFinite({number})) return std::nullopt;
  return LineError(path, line, absl::StrCat("field 1 is no time in nanoseconds: ", field));
}

// Adds the pose of the seven numbers behind the time.
absl::Status AddPose(const TextRow& row, const std::vector<double>& n,
                     const std::optional<int64_t>& timestamp_ns, bool is_w_first,
                     const std::string& path, PoseRows& rows) {
  if (!timestamp_ns.has_value() || !AllFinite({n.begin() + 1, n.begin() + 8})) {
    rows.LeaveOut(row.line);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const Eigen::Quaterniond rotation,
                   is_w_first ? RotationFromQuaternion(n[4], n[5], n[6], n[7], path, row.line)
                              : RotationFromQuaternion(n[7], n[4], n[5], n[6], path, row.line));
  rows.Add(row.line, timestamp_ns, {rotation, Eigen::Vector3d(n[1], n[2], n[3])});
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TrajectoryReading> ReadTumFile(const std::string& path) {
  PoseRows rows(path);
  PoseHeader header;
  RETURN_IF_ERROR(ForEachRow(
      path, [&](absl::string_view comment) { ReadPoseHeader(comment, header); },
      [&](const TextRow& row) -> absl::Status {
        if (row.fields.size() != 8) return WrongCount(row, path, "8");
        ASSIGN_OR_RETURN(const std::vector<double> n, ParseAnyNumbers(row, path));
        ASSIGN_OR_RETURN(const std::optional<int64_t> time_ns,
                         ParseTime(row.fields[0], n[0], path, row.line));
        return AddPose(row, n, time_ns, header.is_w_first.value_or(false), path, rows);
      }));
  TrajectoryReading reading = rows.Finish();
  reading.poses_of = header.poses_of;
  return reading;
}

absl::StatusOr<Trajectory> ReadTumTrajectory(const std::string& path) {
  return AllOf(ReadTumFile(path));
}

std::string TumRow(const StampedPose& pose) {
  const Eigen::Vector3d& t = pose.world_from_camera.translation;
  const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
  return absl::StrFormat("%s %.9f %.9f %.9f %.9f %.9f %.9f %.9f", FormatSeconds(pose.timestamp_ns),
                         t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

absl::Status WriteTumTrajectory(const Trajectory& trajectory, const std::string& path,
                                const std::string& comment) {
  std::vector<std::string> lines;
  lines.reserve(1 + trajectory.size());
  if (!comment.empty()) lines.push_back(absl::StrCat("# ", comment));
  for (const StampedPose& pose : trajectory) lines.push_back(TumRow(pose));
  return WriteLines(lines, path);
}

absl::StatusOr<TrajectoryReading> ReadEurocFile(const std::string& path,
                                                const Rigid3d& body_from_camera) {
  PoseRows rows(path);
  PoseHeader header;
  RETURN_IF_ERROR(ForEachRow(
      path, [&](absl::string_view comment) { ReadPoseHeader(comment, header); },
      [&](const TextRow& row) -> absl::Status {
        if (row.fields.size() < 8) return WrongCount(row, path, "at least 8");
        ASSIGN_OR_RETURN(const std::vector<double> n, ParseAnyNumbers(row, path));
        ASSIGN_OR_RETURN(const std::optional<int64_t> time_ns,
                         ParseNanoseconds(row.fields[0], n[0], path, row.line));
        return AddPose(row, n, time_ns, header.is_w_first.value_or(true), path, rows);
      }));
  TrajectoryReading reading = rows.Finish();
  for (StampedPose& pose : reading.trajectory) {
    pose.world_from_camera = pose.world_from_camera * body_from_camera;
  }
  reading.poses_of = header.poses_of;
  return reading;
}

absl::StatusOr<Trajectory> ReadEurocTrajectory(const std::string& path,
                                               const Rigid3d& body_from_camera) {
  return AllOf(ReadEurocFile(path, body_from_camera));
}

}  // namespace corbslam
