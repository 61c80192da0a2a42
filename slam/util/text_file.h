// Reads files of numbers, line by line. Errors name the file, the line and the field: NOT_FOUND
// when a file can't be opened, INVALID_ARGUMENT when a line can't be understood.
#ifndef CORBSLAM_SLAM_UTIL_TEXT_FILE_H_
#define CORBSLAM_SLAM_UTIL_TEXT_FILE_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam {

// Returns INVALID_ARGUMENT that says "path:line: what".
absl::Status LineError(absl::string_view path, int line, absl::string_view what);

// Calls `use_line` with the number of every line that holds something and is no comment, and with
// its text, stripped of space around it. A comment begins with # at the start of a line or behind
// space. Lines end with LF, CRLF or CR; a UTF-8 byte order mark is passed over, UTF-16 is
// INVALID_ARGUMENT. Stops at the first error.
absl::Status ForEachLine(const std::string& path,
                         const std::function<absl::Status(int, absl::string_view)>& use_line);

// Parses all fields as finite numbers.
absl::StatusOr<std::vector<double>> ParseNumbers(const std::vector<absl::string_view>& fields,
                                                 absl::string_view path, int line);

// Converts seconds as text to nanoseconds, exactly for plain decimals ("1305031102.175304"), to the
// nearest otherwise ("1.037359e-01").
absl::StatusOr<int64_t> ParseSeconds(absl::string_view text);
// Writes nine decimals: "1305031102.175304000".
std::string FormatSeconds(int64_t timestamp_ns);

// Returns the shortest text that is read as the same number.
std::string FormatReal(double number);

// Writes the lines, each with its end: a file that can't be written whole stays what it was. Errors
// are WriteAtomically's.
absl::Status WriteLines(const std::vector<std::string>& lines, const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_TEXT_FILE_H_
