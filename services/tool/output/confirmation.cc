#include "services/tool/output/confirmation.h"

#include <unistd.h>

#include <array>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"

namespace corbslam::services {

bool SomebodyIsThere() { return isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1; }

absl::Status Confirm(const std::string& question, std::FILE* in, std::FILE* out) {
  std::fprintf(out, "%s Type yes to go on: ", question.c_str());
  std::fflush(out);
  std::array<char, 64> answer = {};
  const bool has_answer = std::fgets(answer.data(), answer.size(), in) != nullptr;
  if (has_answer && absl::EqualsIgnoreCase(absl::StripAsciiWhitespace(answer.data()), "yes")) {
    return absl::OkStatus();
  }
  return absl::CancelledError("nothing was deleted");
}

absl::Status ConfirmLoss(const std::string& question, bool is_sure) {
  if (is_sure || !SomebodyIsThere()) return absl::OkStatus();
  return Confirm(question, stdin, stderr);
}

}  // namespace corbslam::services
