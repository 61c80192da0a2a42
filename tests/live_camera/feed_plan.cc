#include "tests/live_camera/feed_plan.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "services/simulation/dice.h"

namespace corbslam::tests {
namespace {

absl::Status Require(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": ", value, ", must be ", least, " to ", most));
}

}  // namespace

absl::Status Validate(const FeedOptions& options) {
  absl::Status status = Require("dropped", options.dropped, 0, 1);
  status.Update(Require("late", options.late, 0, 1));
  status.Update(Require("doubled", options.doubled, 0, 1));
  status.Update(
      Require("dropped, late and doubled", options.dropped + options.late + options.doubled, 0, 1));
  status.Update(Require("late_s", options.late_s, 0, 60));
  status.Update(Require("unplug_at_s", options.unplug_at_s, 0, 1e6));
  status.Update(Require("unplug_s", options.unplug_s, 0, 3600));
  return status;
}

FeedPlan MakeFeedPlan(const std::vector<double>& taken_s, const FeedOptions& options) {
  FeedPlan plan;
  Dice dice(options.seed);
  double before_s = 0;
  const double back_s = options.unplug_at_s + options.unplug_s;
  for (size_t i = 0; i < taken_s.size(); ++i) {
    // Both are thrown for each frame, so that one option's value doesn't change another's frames.
    const double fate = dice.Uniform(0, 1);
    const double late_s = dice.Uniform(0.2, 1) * options.late_s;
    double time_s = taken_s[i];
    if (options.unplug_s > 0 && time_s >= options.unplug_at_s) {
      if (options.hold) {
        time_s += options.unplug_s;
      } else if (time_s < back_s) {
        ++plan.unseen;
        continue;
      }
    }
    if (fate < options.dropped) {
      ++plan.dropped;
      continue;
    }
    const bool late = fate >= 1 - options.late;
    const bool doubled = !late && fate < options.dropped + options.doubled;
    plan.late += late ? 1 : 0;
    plan.doubled += doubled ? 1 : 0;
    before_s = std::max(before_s, late ? time_s + late_s : time_s);
    plan.frames.insert(plan.frames.end(), doubled ? 2 : 1, {i, before_s, time_s});
  }
  return plan;
}

std::string Describe(const FeedPlan& plan) {
  return absl::StrCat(plan.frames.size(), " frames, of them ", plan.late, " late and ",
                      plan.doubled, " doubled; ", plan.dropped, " dropped, ", plan.unseen,
                      " unseen");
}

}  // namespace corbslam::tests
