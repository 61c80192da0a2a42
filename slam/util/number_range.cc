#include "slam/util/number_range.h"

#include <cmath>
#include <iterator>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

// Returns "98 MiB", in the largest unit of which there is a whole number.
std::string FormatWholeBytes(uint64_t bytes) {
  constexpr const char* kUnits[] = {" bytes", " KiB", " MiB", " GiB", " TiB", " PiB"};
  size_t unit = 0;
  for (; unit + 1 < std::size(kUnits) && bytes >= 1024 && bytes % 1024 == 0; ++unit) bytes /= 1024;
  return absl::StrCat(bytes, kUnits[unit]);
}

std::string DescribeBound(double bound, const NumberRange& range, bool is_integer) {
  if (range.is_bytes) return FormatWholeBytes(static_cast<uint64_t>(bound));
  return is_integer ? absl::StrCat(static_cast<int64_t>(bound)) : absl::StrCat(bound);
}

}  // namespace

std::string DescribeRange(const NumberRange& range, bool is_integer) {
  const std::string least = DescribeBound(range.least, range, is_integer);
  if (std::isinf(range.most)) return absl::StrCat(least, " or more");
  return absl::StrCat(least, " to ", DescribeBound(range.most, range, is_integer),
                      range.zero == nullptr ? "" : absl::StrCat(", or 0 for ", range.zero));
}

}  // namespace corbslam
