// Says what a number may be, wherever it comes from: a flag, a file, the wire or a signed setting.
#ifndef CORBSLAM_SLAM_UTIL_NUMBER_RANGE_H_
#define CORBSLAM_SLAM_UTIL_NUMBER_RANGE_H_

#include <cstdint>
#include <limits>
#include <string>

namespace corbslam {

struct NumberRange {
  double least = 0;
  double most = std::numeric_limits<double>::infinity();
  // What 0 means, such as "no bound", where it lies outside of the two.
  const char* zero = nullptr;
  // It is a number of bytes, which people are told as 500 MiB.
  bool is_bytes = false;

  // False for what is no number.
  bool Contains(double value) const {
    return (value >= least && value <= most) || (zero != nullptr && value == 0);
  }
};

// Returns "50 to 20000" or "98 MiB to 1 PiB, or 0 for no bound"; whole numbers have all digits.
std::string DescribeRange(const NumberRange& range, bool is_integer);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_NUMBER_RANGE_H_
