#include "services/simulation/sequence/picture_events.h"

#include <algorithm>

namespace corbslam {
namespace {

constexpr double kBeginningDefocus_px = 8;
// A hand comes and goes within this time.
constexpr double kHandMoves_s = 0.3;

double ExposureAt(const SimulationSpec& spec, double elapsed_s) {
  double factor = 1;
  for (const ExposureStep& step : spec.exposure_steps) {
    if (elapsed_s < step.at_s) break;
    factor = step.factor;
  }
  return factor;
}

double CoveredAt(const Blackout& hand, double elapsed_s) {
  const double since_s = elapsed_s - hand.from_s;
  const double left_s = hand.from_s + hand.duration_s - elapsed_s;
  if (hand.duration_s <= 0 || since_s < 0 || left_s <= 0) return 0;
  return std::min({(since_s + 0.02) / kHandMoves_s, left_s / kHandMoves_s, 1.0});
}

bool IsBlurred(const Beginning& beginning, double elapsed_s) {
  return elapsed_s >= beginning.dark_s && elapsed_s < beginning.dark_s + beginning.blurred_s;
}

}  // namespace

PictureEvents EventsAt(const SimulationSpec& spec, double elapsed_s) {
  PictureEvents events;
  events.exposure = ExposureAt(spec, elapsed_s);
  if (IsBlurred(spec.beginning, elapsed_s)) events.defocus_px = kBeginningDefocus_px;
  events.covered = CoveredAt(spec.hand, elapsed_s);
  return events;
}

}  // namespace corbslam
