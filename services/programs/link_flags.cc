#include "services/programs/link_flags.h"

#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

// Returns what is wrong with the value; empty if it is good.
std::string CheckKbps(const std::string& text) {
  uint64_t kbps = 0;
  const bool good =
      absl::SimpleAtoi(text, &kbps) && (kbps == 0 || (kbps >= kLeastKbps && kbps <= kMostKbps));
  if (good) return "";
  return absl::StrCat("\"", text, "\" is neither 0 (no bound) nor a whole number of kbit/s from ",
                      kLeastKbps, " to ", kMostKbps);
}

void Add(CLI::App& app, const char* flag, uint64_t& kbps, const char* what) {
  app.add_option(flag, kbps, what)
      ->check(CLI::Validator(&CheckKbps, ""))
      ->type_name("KBPS")
      ->capture_default_str();
}

}  // namespace

void AddLinkFlags(CLI::App& app, LinkFlags& flags) {
  Add(app, "--uplink-kbps", flags.uplink_kbps,
      "kbit/s to the map store at most; what is over waits; 0: no bound");
  Add(app, "--downlink-kbps", flags.downlink_kbps,
      "kbit/s of shared updates from it at most; 0: no bound");
}

absl::Status CheckNoLinkFlags(const LinkFlags& flags) {
  if (flags.uplink_kbps > 0) return absl::InvalidArgumentError("--uplink-kbps needs --server");
  if (flags.downlink_kbps > 0) return absl::InvalidArgumentError("--downlink-kbps needs --server");
  return absl::OkStatus();
}

}  // namespace corbslam::services
