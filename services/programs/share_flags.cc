#include "services/programs/share_flags.h"

#include <map>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "services/command_line/help_formatter.h"
#include "services/convert/limits.h"

namespace corbslam::services {
namespace {

// Returns what is wrong with the value; empty if it is good.
std::string CheckRadius(const std::string& text) {
  double radius_m = 0;
  const bool good = absl::SimpleAtod(text, &radius_m) && radius_m >= kMinShareRadius_m &&
                    radius_m <= kMaxShareRadius_m;
  if (good) return "";
  return absl::StrCat("\"", text, "\" is no number of metres from ", kMinShareRadius_m, " to ",
                      kMaxShareRadius_m);
}

}  // namespace

void AddShareFlags(CLI::App& app, ShareFlags& flags) {
  app.add_option_function<ShareMode>(
         "--share", [&flags](ShareMode mode) { flags.mode = mode; },
         "What the map store tells the robot: everything; nearby: others' keyframes near "
         "it; corrections: where its own map is in all's; none: nothing, and WatchPose has "
         "no global_from_local. With --memory-budget it is nearby unless said otherwise")
      ->transform(Choice({{"none", static_cast<int>(ShareMode::kNone)},
                          {"corrections", static_cast<int>(ShareMode::kCorrections)},
                          {"nearby", static_cast<int>(ShareMode::kNearby)},
                          {"everything", static_cast<int>(ShareMode::kEverything)}}))
      ->type_name("none|corrections|nearby|everything")
      ->default_str("everything")
      ->group(kRareGroup);
  app.add_option_function<double>(
         "--share-radius",
         [&flags](double radius_m) {
           flags.radius_m = radius_m;
           flags.has_radius = true;
         },
         "With --share nearby: how far from the robot's newest keyframe, in metres")
      ->check(CLI::Validator(&CheckRadius, ""))
      ->type_name("METRES")
      ->default_str(absl::StrCat(flags.radius_m))
      ->group(kRareGroup);
}

absl::Status CheckShareFlags(const ShareFlags& flags, bool has_server) {
  const ShareMode mode = flags.mode.value_or(flags.otherwise);
  if (flags.has_radius && mode != ShareMode::kNearby) {
    return absl::InvalidArgumentError(
        absl::StrCat("--share-radius is ", flags.radius_m, ", but needs --share nearby"));
  }
  if (has_server || mode == ShareMode::kEverything) return absl::OkStatus();
  return absl::InvalidArgumentError("--share needs --server");
}

ShareScope ScopeOf(const ShareFlags& flags) {
  ShareScope scope;
  scope.mode = flags.mode.value_or(flags.otherwise);
  if (scope.mode == ShareMode::kNearby) scope.radius_m = flags.radius_m;
  return scope;
}

ShareFlags WithBoundedMemory(ShareFlags flags) {
  flags.otherwise = ShareMode::kNearby;
  return flags;
}

}  // namespace corbslam::services
