// This is KITTI's part of trajectory_io.h.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

using OptionalTimes = std::vector<std::optional<int64_t>>;  // None: the time is not finite.

struct KittiRow {
  int line = 0;
  std::optional<Rigid3d> pose;  // None: the pose is not finite.
};

absl::StatusOr<KittiRow> ParseKittiRow(const TextRow& row, const std::string& path) {
  if (row.fields.size() != 12) return WrongCount(row, path, "12");
  ASSIGN_OR_RETURN(const std::vector<double> n, ParseAnyNumbers(row, path));
  if (!AllFinite(n)) return KittiRow{row.line, std::nullopt};
  Eigen::Matrix3d matrix;
  matrix << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  ASSIGN_OR_RETURN(const Eigen::Quaterniond rotation, RotationFromMatrix(matrix, path, row.line));
  return KittiRow{row.line, Rigid3d{rotation, Eigen::Vector3d(n[3], n[7], n[11])}};
}

absl::StatusOr<std::vector<KittiRow>> ReadKittiRows(const std::string& path) {
  std::vector<KittiRow> rows;
  RETURN_IF_ERROR(ForEachRow(
      path, [](absl::string_view) {},
      [&](const TextRow& row) -> absl::Status {
        ASSIGN_OR_RETURN(rows.emplace_back(), ParseKittiRow(row, path));
        return absl::OkStatus();
      }));
  return rows;
}

absl::StatusOr<OptionalTimes> ReadTimes(const std::string& path) {
  OptionalTimes times_ns;
  RETURN_IF_ERROR(ForEachRow(
      path, [](absl::string_view) {},
      [&](const TextRow& row) -> absl::Status {
        if (row.fields.size() != 1) return WrongCount(row, path, "1");
        ASSIGN_OR_RETURN(const std::vector<double> number, ParseAnyNumbers(row, path));
        ASSIGN_OR_RETURN(times_ns.emplace_back(),
                         ParseTime(row.fields[0], number[0], path, row.line));
        return absl::OkStatus();
      }));
  return times_ns;
}

absl::StatusOr<TrajectoryReading> Collect(const std::vector<KittiRow>& poses,
                                          const OptionalTimes& times_ns, const std::string& path,
                                          const std::string& times_path) {
  if (poses.size() != times_ns.size()) {
    return absl::InvalidArgumentError(absl::StrCat(path, " has ", poses.size(), " poses, ",
                                                   times_path, " has ", times_ns.size(), " times"));
  }
  PoseRows rows(path);
  for (size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].pose.has_value()) {
      rows.Add(poses[i].line, times_ns[i], *poses[i].pose);
    } else {
      rows.LeaveOut(poses[i].line);
    }
  }
  return rows.Finish();
}

}  // namespace

absl::StatusOr<TrajectoryReading> ReadKittiFile(const std::string& poses_path,
                                                const std::string& times_path) {
  ASSIGN_OR_RETURN(const std::vector<KittiRow> poses, ReadKittiRows(poses_path));
  ASSIGN_OR_RETURN(const OptionalTimes times_ns, ReadTimes(times_path));
  return Collect(poses, times_ns, poses_path, times_path);
}

absl::StatusOr<TrajectoryReading> ReadKittiFile(const std::string& poses_path,
                                                const std::vector<int64_t>& times_ns) {
  ASSIGN_OR_RETURN(const std::vector<KittiRow> poses, ReadKittiRows(poses_path));
  return Collect(poses, {times_ns.begin(), times_ns.end()}, poses_path, "the sequence");
}

absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path,
                                               const std::string& times_path) {
  return AllOf(ReadKittiFile(poses_path, times_path));
}

absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path) {
  constexpr int64_t kFramePeriod_ns = 100'000'000;
  ASSIGN_OR_RETURN(const std::vector<KittiRow> poses, ReadKittiRows(poses_path));
  OptionalTimes times_ns;
  for (size_t i = 0; i < poses.size(); ++i) {
    times_ns.push_back(static_cast<int64_t>(i) * kFramePeriod_ns);
  }
  return AllOf(Collect(poses, times_ns, poses_path, ""));
}

absl::Status WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path) {
  std::vector<std::string> lines;
  lines.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) {
    Eigen::Matrix<double, 3, 4> matrix;
    matrix << pose.world_from_camera.rotation.toRotationMatrix(),
        pose.world_from_camera.translation;
    std::vector<std::string> numbers;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        numbers.push_back(absl::StrFormat("%.9e", matrix(row, column)));
      }
    }
    lines.push_back(absl::StrJoin(numbers, " "));
  }
  return WriteLines(lines, path);
}

}  // namespace corbslam
