#include "services/simulation/sequence/frame_clock.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

int64_t ToNanoseconds(double seconds) { return std::llround(seconds * 1e9); }

// Counts the frames that are taken from the phase on while time lasts.
size_t CountFrames(double rate_hz, double phase, int64_t lasts_ns) {
  if (lasts_ns < 0) return 0;
  // Half a nanosecond that rounding took must not cost a frame.
  const double last = std::floor((static_cast<double>(lasts_ns) + 0.6) * 1e-9 * rate_hz - phase);
  return last < 0 ? 0 : static_cast<size_t>(last) + 1;
}

}  // namespace

FrameClock::FrameClock(const SimulationSpec& spec, double rate_hz, int64_t way_ns)
    : spec_(spec), rate_hz_(rate_hz) {
  standing_ns_ = ToNanoseconds(spec.beginning.total_s());
  const size_t undisturbed = CountFrames(rate_hz, spec.phase, way_ns);
  turning_ns_ = ToNanoseconds(
      (static_cast<double>(std::max<size_t>(undisturbed, 1) - 1) + 2 * spec.phase) / rate_hz);
  frame_count_ = CountFrames(rate_hz, spec.phase, standing_ns_ + way_ns);
  if (!spec.kidnap.has_value()) return;
  const int64_t at_ns = ToNanoseconds(spec.kidnap->at_s);
  const int64_t to_ns = ToNanoseconds(spec.kidnap->to_s);
  if (at_ns > standing_ns_ + way_ns) return;
  // The frames take what is left of the way from there on.
  frame_count_ = CountFrames(rate_hz, spec.phase, at_ns + std::max<int64_t>(way_ns - to_ns, 0));
}

int64_t FrameClock::ElapsedAt(size_t frame) const {
  return ToNanoseconds((static_cast<double>(frame) + spec_.phase) / rate_hz_);
}

int64_t FrameClock::TimestampAt(size_t frame) const {
  return ToNanoseconds(spec_.start_s) + ElapsedAt(frame);
}

int64_t FrameClock::WayTimeAt(size_t frame, int64_t since_ns) const {
  const int64_t elapsed_ns = ElapsedAt(frame) + since_ns;
  int64_t time_ns = elapsed_ns - standing_ns_;
  if (standing_ns_ > 0) time_ns = std::max<int64_t>(time_ns, 0);
  if (spec_.kidnap.has_value()) {
    const int64_t at_ns = ToNanoseconds(spec_.kidnap->at_s);
    if (ElapsedAt(frame) >= at_ns) time_ns = elapsed_ns + ToNanoseconds(spec_.kidnap->to_s) - at_ns;
  }
  return spec_.turned ? turning_ns_ - time_ns : time_ns;
}

bool FrameClock::IsDark(size_t frame) const {
  if (ElapsedAt(frame) < ToNanoseconds(spec_.beginning.dark_s)) return true;
  const int64_t from_ns = ToNanoseconds(spec_.blackout.from_s);
  const int64_t elapsed_ns = ElapsedAt(frame);
  return elapsed_ns >= from_ns && elapsed_ns < from_ns + ToNanoseconds(spec_.blackout.duration_s);
}

}  // namespace corbslam
