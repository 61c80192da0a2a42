#include "client_agent/source/option_values.h"

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {

absl::Status BadOption(absl::string_view key, absl::string_view value, absl::string_view wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("source option ", key, "=", value, ": wants ", wanted));
}

absl::Status ParseReal(absl::string_view key, absl::string_view value, double least, double most,
                       double& number) {
  if (absl::SimpleAtod(value, &number) && number >= least && number <= most) {
    return absl::OkStatus();
  }
  return BadOption(key, value, absl::StrCat("a number from ", least, " to ", most));
}

absl::Status ParseFlag(absl::string_view key, absl::string_view value, bool& flag) {
  if (value != "" && value != "0" && value != "1") return BadOption(key, value, "0 or 1");
  flag = value != "0";
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent
