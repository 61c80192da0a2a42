#include "map_store/fleet/load_meter.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace corbslam::map_store {
namespace {

// After so long, a value counts for 1/e of what it did. What a move changes is to be seen before
// the next one (BalanceRules::store_rests).
constexpr absl::Duration kAveragedOver = absl::Seconds(20);

}  // namespace

std::optional<WeighedStore> LoadMeter::Note(const Reading& reading) {
  const double seconds =
      last_.has_value() ? absl::ToDoubleSeconds(reading.time - last_->time) : 0.0;
  const double share = -std::expm1(-seconds / absl::ToDoubleSeconds(kAveragedOver));
  std::map<std::string, Pace> paces;
  double all_per_s = 0;
  for (const auto& [mission, counted] : reading.missions) {
    // A mission that has just been read has no past here.
    const auto it = paces_.find(mission);
    Pace pace = it == paces_.end() ? Pace{counted.keyframes, 0} : it->second;
    if (seconds > 0) {
      const uint64_t came = counted.keyframes - std::min(counted.keyframes, pace.keyframes);
      pace.keyframes_per_s += share * (static_cast<double>(came) / seconds - pace.keyframes_per_s);
    }
    pace.keyframes = counted.keyframes;
    all_per_s += pace.keyframes_per_s;
    paces[mission] = pace;
  }
  const bool is_first = !last_.has_value();
  if (seconds > 0) {
    const double busy = (reading.processor_s - last_->processor_s) / seconds;
    busy_processors_ += share * (busy - busy_processors_);
  }
  paces_ = std::move(paces);
  last_ = reading;
  if (is_first) return std::nullopt;
  WeighedStore weighed;
  weighed.load = {busy_processors_, reading.processors, reading.resident_bytes,
                  reading.budget_bytes, all_per_s};
  for (const auto& [mission, pace] : paces_) {
    const double part = all_per_s > 0 ? pace.keyframes_per_s / all_per_s : 0;
    weighed.missions[mission] = {part * busy_processors_, reading.missions.at(mission).bytes};
  }
  return weighed;
}

}  // namespace corbslam::map_store
