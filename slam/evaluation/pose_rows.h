// Rows of text that hold poses, and what of them is usable.
#ifndef CORBSLAM_SLAM_EVALUATION_POSE_ROWS_H_
#define CORBSLAM_SLAM_EVALUATION_POSE_ROWS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/camera/recorded_camera.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// A trajectory with what is to be said of its file.
struct TrajectoryReading {
  // The poses are sorted, and no time is there twice.
  Trajectory trajectory;
  // Number of rows that hold no pose because a field is NaN or infinite.
  size_t rows_not_finite = 0;
  // Number of rows whose time an earlier row has; the first one counts.
  size_t rows_repeated = 0;
  // Number of rows that are earlier than one before them.
  size_t rows_out_of_order = 0;
  // A sentence for each of these that is not 0, with file, number and the first line.
  std::vector<std::string> notes;
  // What the file says that its poses are of.
  std::optional<PosesOf> poses_of;
};

// Takes the rows of one file in their order.
class PoseRows {
 public:
  // `row_word` names what the number of a row counts.
  explicit PoseRows(std::string path, std::string row_word = "line")
      : path_(std::move(path)), row_word_(std::move(row_word)) {}

  // A pose or a time that isn't finite is left out.
  void Add(int line, const std::optional<int64_t>& timestamp_ns, const Rigid3d& pose);
  void LeaveOut(int line) { NoteLine(line, not_finite_); }
  TrajectoryReading Finish();

 private:
  struct Lines {
    size_t count = 0;
    int first = 0;
  };
  static void NoteLine(int line, Lines& lines) {
    if (lines.count++ == 0) lines.first = line;
  }
  void AddNote(const Lines& lines, absl::string_view what, std::vector<std::string>& notes) const;

  struct Row {
    int line = 0;
    StampedPose pose;
  };
  const std::string path_;
  const std::string row_word_;
  std::vector<Row> rows_;
  Lines not_finite_;
  Lines out_of_order_;
};

struct TextRow {
  int line = 0;
  bool has_commas = false;
  std::vector<absl::string_view> fields;
};

// Calls `use_comment` with each line that begins with #, or holds no number before the first row
// (a header without #), and `use_row` with the fields of every other that holds something.
// Separators are commas, semicolons, spaces and tabs; a byte order mark and what follows a # are no
// fields. Stops at the first error. NOT_FOUND: the file can't be opened.
absl::Status ForEachRow(const std::string& path,
                        const std::function<void(absl::string_view)>& use_comment,
                        const std::function<absl::Status(const TextRow&)>& use_row);

// Parses numbers that need not be finite. INVALID_ARGUMENT names file, line and field.
absl::StatusOr<std::vector<double>> ParseAnyNumbers(const TextRow& row, absl::string_view path);

// INVALID_ARGUMENT: the row has not as many fields as `expected` says.
absl::Status WrongCount(const TextRow& row, absl::string_view path, absl::string_view expected);

// Parses seconds, or nanoseconds since 1970 where they are 18 digits or more; `number` is the same
// field as a number. Nullopt: the time is not finite.
absl::StatusOr<std::optional<int64_t>> ParseTime(absl::string_view field, double number,
                                                 absl::string_view path, int line);

// Returns the trajectory of a file in which every row must hold a pose: INVALID_ARGUMENT names the
// first row that doesn't.
absl::StatusOr<Trajectory> AllOf(absl::StatusOr<TrajectoryReading> reading);

bool AllFinite(const std::vector<double>& numbers);

// INVALID_ARGUMENT names the line: a quaternion whose length isn't 1 within 0.01, a matrix (row by
// row) that is no rotation.
absl::StatusOr<Eigen::Quaterniond> RotationFromQuaternion(double w, double x, double y, double z,
                                                          absl::string_view path, int line);
absl::StatusOr<Eigen::Quaterniond> RotationFromMatrix(const Eigen::Matrix3d& matrix,
                                                      absl::string_view path, int line);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_POSE_ROWS_H_
