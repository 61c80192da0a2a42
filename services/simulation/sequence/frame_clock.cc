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
    : spec_(spec), rate_hz_(rate_hz), way_ns_(way_ns) {
  standing_ns_ = ToNanoseconds(spec.beginning.total_s());
  setting_off_ns_ = ToNanoseconds(spec.set_off_s);
  const size_t undisturbed = CountFrames(rate_hz, spec.phase, way_ns);
  turning_ns_ = ToNanoseconds(
      (static_cast<double>(std::max<size_t>(undisturbed, 1) - 1) + 2 * spec.phase) / rate_hz);
  if (setting_off_ns_ > 0) turning_ns_ = way_ns;
  const int64_t lasts_ns = standing_ns_ + setting_off_ns_ / 2 + way_ns;
  frame_count_ = CountFrames(rate_hz, spec.phase, lasts_ns);
  if (!spec.kidnap.has_value()) return;
  const int64_t at_ns = ToNanoseconds(spec.kidnap->at_s);
  const int64_t to_ns = ToNanoseconds(spec.kidnap->to_s);
  if (at_ns > lasts_ns) return;
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
  if (!spec_.kidnap.has_value()) return WayTimeOf(elapsed_ns);
  const int64_t at_ns = ToNanoseconds(spec_.kidnap->at_s);
  if (ElapsedAt(frame) < at_ns) return WayTimeOf(elapsed_ns);
  return Turned(elapsed_ns + ToNanoseconds(spec_.kidnap->to_s) - at_ns);
}

int64_t FrameClock::WayTimeOf(int64_t elapsed_ns) const {
  int64_t time_ns = elapsed_ns - standing_ns_;
  if (standing_ns_ > 0 || setting_off_ns_ > 0) time_ns = std::max<int64_t>(time_ns, 0);
  return Turned(SetOff(time_ns));
}

int64_t FrameClock::SetOff(int64_t time_ns) const {
  if (time_ns >= setting_off_ns_) return time_ns - setting_off_ns_ / 2;
  if (time_ns < 0) return time_ns;
  const double lasts_ns = static_cast<double>(setting_off_ns_);
  const double share = static_cast<double>(time_ns) / lasts_ns;
  return std::llround(lasts_ns * share * share * share * (1 - 0.5 * share));
}

int64_t FrameClock::Turned(int64_t time_ns) const {
  return spec_.turned ? turning_ns_ - time_ns : time_ns;
}

TimeSpan FrameClock::PhysicalSpan() const {
  const int64_t before_ns = standing_ns_ + setting_off_ns_ / 2;
  // A way that is driven the other way round may be entered behind its end, by the phase.
  const int64_t entered_ns = spec_.turned ? turning_ns_ - way_ns_ : 0;
  const int64_t left_ns = spec_.turned ? turning_ns_ : way_ns_;
  return {before_ns > 0 ? 0 : std::max<int64_t>(entered_ns, 0), before_ns + left_ns};
}

bool FrameClock::IsDark(size_t frame) const {
  if (ElapsedAt(frame) < ToNanoseconds(spec_.beginning.dark_s)) return true;
  const int64_t from_ns = ToNanoseconds(spec_.blackout.from_s);
  const int64_t elapsed_ns = ElapsedAt(frame);
  return elapsed_ns >= from_ns && elapsed_ns < from_ns + ToNanoseconds(spec_.blackout.duration_s);
}

}  // namespace corbslam
