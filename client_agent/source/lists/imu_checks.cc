#include "client_agent/source/lists/imu_checks.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

constexpr double kShortestImuInterval_s = 5e-5;
constexpr double kLongestImuInterval_s = 1;
// A gap is longer than this, and than so many usual intervals.
constexpr double kLeastImuGap_s = 0.02;
constexpr double kImuGap_intervals = 3;
// What may be missing at the beginning and at the end of the pictures.
constexpr double kMostUncovered_s = 0.1;
// Samples this long before the first picture and behind the last are looked at, too.
constexpr int64_t kAround_ns = 10'000'000'000;
constexpr double kOtherRate = 0.2;
// Median length of what is measured where gravity is in it, m/s2.
constexpr double kLeastForce_mps2 = 7;
constexpr double kMostForce_mps2 = 13;
constexpr double kLeastPossibleForce_mps2 = 2;
constexpr double kMostPossibleForce_mps2 = 50;
// Of the median, a length that 90 % are above.
constexpr double kSteadyForce = 0.6;
// Racing drones turn at 10 to 20 rad/s at times, nothing does all the time; sensors end at 35.
constexpr double kMostUsualTurning_rps = 4;
constexpr double kMostTurning_rps = 36;
// Samples at an axis's extreme: so many in a row, and so many in all.
constexpr size_t kStuckInARow = 3;
constexpr size_t kStuckInAll = 6;
constexpr double kLeastSaturation_rps = 1.5;
constexpr double kLeastSaturation_mps2 = 18;
// Fewer samples than this say nothing of constant axes and repeated values.
constexpr size_t kFewImuSamples = 50;
constexpr double kRepeatedShare = 0.2;

double SecondsBetween(int64_t from_ns, int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

std::string RangeText(int64_t first_ns, int64_t last_ns) {
  return absl::StrCat(FormatSeconds(first_ns), " to ", FormatSeconds(last_ns), " s");
}

// One look at samples: what is found is added to `findings`.
class ImuLook {
 public:
  ImuLook(const ImuExpectation& expected, SourceFindings& findings)
      : expected_(expected), findings_(findings) {}

  void Warn(const char* code, absl::string_view what) const {
    findings_.push_back({FindingLevel::kWarning, code, absl::StrCat(expected_.from, ": ", what)});
  }
  // An error, or a warning where everything is to be trusted.
  absl::Status Refuse(const char* code, absl::string_view what) const {
    if (!expected_.trust) {
      return absl::InvalidArgumentError(
          absl::StrCat(expected_.from, ": ", what,
                       ". If it is right, say ?trust-calibration; ?imu=0 plays without it"));
    }
    Warn(code, what);
    return absl::OkStatus();
  }

  absl::Status CheckTimes(const ImuSamples& samples, ImuStatistics& statistics) const;
  absl::Status CheckOverlap(const ImuSamples& samples) const;
  void CheckCover(const ImuSamples& samples) const;
  void CheckGaps(const ImuSamples& samples, ImuStatistics& statistics) const;
  absl::Status CheckForce(const ImuSamples& samples) const;
  void CheckTurning(const ImuSamples& samples) const;
  absl::Status CheckConstant(const ImuSamples& samples) const;
  void CheckSaturation(const ImuSamples& samples) const;
  void CheckRepeated(const ImuSamples& samples) const;

 private:
  const ImuExpectation& expected_;
  SourceFindings& findings_;
};

// One axis of a sensor.
struct ImuAxis {
  const char* sensor;
  Eigen::Vector3d ImuSample::*values;
  int axis;

  double Of(const ImuSample& sample) const { return (sample.*values)(axis); }
  std::string Name() const { return absl::StrCat(sensor, "'s ", std::string(1, "xyz"[axis])); }
};

constexpr char kGyroscope[] = "the gyroscope";
constexpr char kAccelerometer[] = "the accelerometer";

std::vector<ImuAxis> ImuAxes() {
  std::vector<ImuAxis> axes;
  for (int axis = 0; axis < 3; ++axis) {
    axes.push_back({kGyroscope, &ImuSample::angular_velocity_rps, axis});
  }
  for (int axis = 0; axis < 3; ++axis) {
    axes.push_back({kAccelerometer, &ImuSample::specific_force_mps2, axis});
  }
  return axes;
}

std::vector<double> LengthsOf(const ImuSamples& samples, Eigen::Vector3d ImuSample::*values) {
  std::vector<double> lengths;
  lengths.reserve(samples.size());
  for (const ImuSample& sample : samples) lengths.push_back((sample.*values).norm());
  return lengths;
}

absl::Status ImuLook::CheckTimes(const ImuSamples& samples, ImuStatistics& statistics) const {
  std::vector<double> intervals_s;
  for (size_t i = 1; i < samples.size(); ++i) {
    intervals_s.push_back(SecondsBetween(samples[i - 1].timestamp_ns, samples[i].timestamp_ns));
  }
  const double median_s = Median(std::move(intervals_s));
  if (median_s < kShortestImuInterval_s || median_s > kLongestImuInterval_s) {
    const char* const unit = median_s > kLongestImuInterval_s ? "another unit"
                             : median_s < 1e-7                ? "milliseconds"
                                                              : "microseconds";
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s: the median interval between samples of the IMU is %.6g s, must be in [%g, %g]: its "
        "times are in %s, wanted are nanoseconds",
        expected_.from, median_s, kShortestImuInterval_s, kLongestImuInterval_s, unit));
  }
  statistics.rate_hz = 1 / median_s;
  if (expected_.rate_hz.has_value() &&
      std::abs(statistics.rate_hz / *expected_.rate_hz - 1) > kOtherRate) {
    Warn("imu-rate-other",
         absl::StrFormat("the IMU measured %.4g times a second, its calibration says %.4g: is it "
                         "that of this IMU, and are all samples there?",
                         statistics.rate_hz, *expected_.rate_hz));
  }
  return absl::OkStatus();
}

absl::Status ImuLook::CheckOverlap(const ImuSamples& samples) const {
  const int64_t first_ns = samples.front().timestamp_ns;
  const int64_t last_ns = samples.back().timestamp_ns;
  if (first_ns <= expected_.last_picture_ns && last_ns >= expected_.first_picture_ns) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      expected_.from, ": the IMU measured from ", RangeText(first_ns, last_ns),
      ", the pictures were taken from ",
      RangeText(expected_.first_picture_ns, expected_.last_picture_ns),
      ": they have no time in common. Are both of one recording, by one clock, and the IMU's times "
      "in nanoseconds? ?imu=0 plays without it"));
}

void ImuLook::CheckCover(const ImuSamples& samples) const {
  const double late_s = SecondsBetween(expected_.first_picture_ns, samples.front().timestamp_ns);
  const double early_s = SecondsBetween(samples.back().timestamp_ns, expected_.last_picture_ns);
  if (std::max(late_s, early_s) <= kMostUncovered_s) return;
  Warn("imu-covers-part",
       absl::StrFormat("the IMU begins %.3f s after the first picture and ends %.3f s before the "
                       "last: pictures outside are tracked without it",
                       std::max(late_s, 0.0), std::max(early_s, 0.0)));
}

void ImuLook::CheckGaps(const ImuSamples& samples, ImuStatistics& statistics) const {
  const double interval_s = 1 / statistics.rate_hz;
  const double least_s = std::max(kLeastImuGap_s, kImuGap_intervals * interval_s);
  double missing = 0;
  int64_t longest_ns = 0;
  for (size_t i = 1; i < samples.size(); ++i) {
    const double gap_s = SecondsBetween(samples[i - 1].timestamp_ns, samples[i].timestamp_ns);
    if (gap_s <= least_s) continue;
    ++statistics.gaps;
    missing += std::round(gap_s / interval_s) - 1;
    if (gap_s <= statistics.longest_gap_s) continue;
    statistics.longest_gap_s = gap_s;
    longest_ns = samples[i - 1].timestamp_ns;
  }
  if (statistics.gaps == 0) return;
  Warn("imu-gaps",
       absl::StrFormat("some %.0f samples of the IMU are missing in %d gaps, the longest of %.3f s "
                       "from %s s on: nothing is known of the motion in between. Record it with "
                       "fewer losses",
                       missing, statistics.gaps, statistics.longest_gap_s,
                       FormatSeconds(longest_ns)));
}

absl::Status ImuLook::CheckForce(const ImuSamples& samples) const {
  std::vector<double> lengths = LengthsOf(samples, &ImuSample::specific_force_mps2);
  const double median = Median(lengths);
  if (median >= kLeastForce_mps2 && median <= kMostForce_mps2) return absl::OkStatus();
  const std::string what = absl::StrFormat(
      "the median length of the IMU's accelerations is %.4g, at rest it is 9.8 m/s2", median);
  // Where gravity is in them, they are hardly ever far shorter.
  std::sort(lengths.begin(), lengths.end());
  const bool is_steady = lengths[lengths.size() / 10] >= kSteadyForce * median;
  if (median >= 0.8 && median <= 1.2 && is_steady) {
    return Refuse("imu-force-odd",
                  what + ": they are in g. Multiply them by 9.80665, m/s2 are wanted");
  }
  if (median >= 800 && median <= 1200) {
    return Refuse("imu-force-odd",
                  what + ": they are in mg. Multiply them by 0.00980665, m/s2 are wanted");
  }
  if (median < kLeastPossibleForce_mps2) {
    return Refuse("imu-force-odd", what +
                                       ": gravity was taken out of them, gyroscope and "
                                       "accelerometer are exchanged, or they are in g. Give what "
                                       "the accelerometer measures, in m/s2, behind the "
                                       "gyroscope's three fields");
  }
  if (median > kMostPossibleForce_mps2) {
    return Refuse("imu-force-odd", what + ": they are in another unit, m/s2 are wanted");
  }
  Warn("imu-force-odd", what + ": are they in m/s2, and is gravity in them?");
  return absl::OkStatus();
}

void ImuLook::CheckTurning(const ImuSamples& samples) const {
  std::vector<double> lengths = LengthsOf(samples, &ImuSample::angular_velocity_rps);
  const double most = *std::max_element(lengths.begin(), lengths.end());
  const double median = Median(std::move(lengths));
  if (median <= kMostUsualTurning_rps && most <= kMostTurning_rps) return;
  Warn("imu-turning-odd",
       absl::StrFormat("the IMU turns at %.4g in the median and %.4g at most, in rad/s at most %g "
                       "and %g: are these degrees a second? Then multiply them by 0.0174533",
                       median, most, kMostUsualTurning_rps, kMostTurning_rps));
}

absl::Status ImuLook::CheckConstant(const ImuSamples& samples) const {
  if (samples.size() < kFewImuSamples) return absl::OkStatus();
  std::vector<std::string> constant;
  for (const char* const sensor : {kGyroscope, kAccelerometer}) {
    size_t axes = 0;
    for (const ImuAxis& axis : ImuAxes()) {
      if (axis.sensor != sensor) continue;
      const double value = axis.Of(samples[0]);
      const bool is_constant =
          std::all_of(samples.begin(), samples.end(),
                      [&](const ImuSample& sample) { return axis.Of(sample) == value; });
      if (!is_constant) continue;
      ++axes;
      constant.push_back(absl::StrCat(axis.Name(), " is ", value));
    }
    if (axes < 3) continue;
    return Refuse("imu-axis-constant",
                  absl::StrCat(sensor, " measured one and the same in all ", samples.size(),
                               " samples (", constant.back(), "): it is not there, or not read"));
  }
  for (const std::string& axis : constant) {
    Warn("imu-axis-constant", absl::StrCat(axis, " in all ", samples.size(),
                                           " samples: is this axis read? It may be dead"));
  }
  return absl::OkStatus();
}

// Returns how many samples lie at the axis's extreme, `sign` times its largest value, if some of
// them follow each other.
size_t CountStuck(const ImuSamples& samples, const ImuAxis& axis, double sign, double extreme) {
  size_t all = 0;
  size_t row = 0;
  size_t longest = 0;
  for (const ImuSample& sample : samples) {
    row = sign * axis.Of(sample) == extreme ? row + 1 : 0;
    all += row > 0 ? 1 : 0;
    longest = std::max(longest, row);
  }
  return longest >= kStuckInARow ? all : 0;
}

void ImuLook::CheckSaturation(const ImuSamples& samples) const {
  for (const ImuAxis& axis : ImuAxes()) {
    const bool turns = axis.sensor == kGyroscope;
    for (const double sign : {1.0, -1.0}) {
      double extreme = -1;
      for (const ImuSample& sample : samples) extreme = std::max(extreme, sign * axis.Of(sample));
      if (extreme < (turns ? kLeastSaturation_rps : kLeastSaturation_mps2)) continue;
      const size_t stuck = CountStuck(samples, axis, sign, extreme);
      // A constant axis is told as such.
      if (stuck < kStuckInAll || stuck == samples.size()) continue;
      Warn("imu-saturated",
           absl::StrFormat("%d samples of %s axis are at its extreme, %.6g %s, some of them in a "
                           "row: it measures no more than that. Set a wider range, or mount the "
                           "IMU softer",
                           stuck, axis.Name(), sign * extreme, turns ? "rad/s" : "m/s2"));
    }
  }
}

void ImuLook::CheckRepeated(const ImuSamples& samples) const {
  size_t repeated = 0;
  for (size_t i = 1; i < samples.size(); ++i) {
    const bool same = samples[i].angular_velocity_rps == samples[i - 1].angular_velocity_rps &&
                      samples[i].specific_force_mps2 == samples[i - 1].specific_force_mps2;
    repeated += same ? 1 : 0;
  }
  if (samples.size() < kFewImuSamples ||
      static_cast<double>(repeated) <= kRepeatedShare * static_cast<double>(samples.size())) {
    return;
  }
  Warn("imu-values-repeat",
       absl::StrCat(repeated, " of ", samples.size(),
                    " samples of the IMU have all six values of the one before: it is read more "
                    "often than it measures. Record each measurement once"));
}

// Returns the samples while pictures were taken, and some around.
ImuSamples AroundPictures(const ImuSamples& samples, const ImuExpectation& expected) {
  ImuSamples around;
  for (const ImuSample& sample : samples) {
    if (sample.timestamp_ns >= expected.first_picture_ns - kAround_ns &&
        sample.timestamp_ns <= expected.last_picture_ns + kAround_ns) {
      around.push_back(sample);
    }
  }
  return around;
}

}  // namespace

absl::StatusOr<ImuStatistics> MeasureImu(const ImuSamples& samples, const ImuExpectation& expected,
                                         SourceFindings& findings) {
  const ImuLook look(expected, findings);
  ImuStatistics statistics;
  statistics.samples = samples.size();
  statistics.first_ns = samples.front().timestamp_ns;
  statistics.last_ns = samples.back().timestamp_ns;
  RETURN_IF_ERROR(look.CheckTimes(samples, statistics));
  RETURN_IF_ERROR(look.CheckOverlap(samples));
  look.CheckCover(samples);
  const ImuSamples around = AroundPictures(samples, expected);
  if (around.size() < 2) {
    return absl::InvalidArgumentError(absl::StrCat(
        expected.from, ": there is no sample of the IMU within 10 s of the pictures, from ",
        RangeText(expected.first_picture_ns, expected.last_picture_ns),
        ": is it of this recording? ?imu=0 plays without it"));
  }
  look.CheckGaps(around, statistics);
  RETURN_IF_ERROR(look.CheckConstant(around));
  RETURN_IF_ERROR(look.CheckForce(around));
  look.CheckTurning(around);
  look.CheckSaturation(around);
  look.CheckRepeated(around);
  return statistics;
}

std::string DescribeImu(const ImuStatistics& statistics, const std::string& from) {
  std::string text =
      absl::StrFormat("%.4g Hz, %d samples from %s, from %s", statistics.rate_hz,
                      statistics.samples, RangeText(statistics.first_ns, statistics.last_ns), from);
  if (statistics.gaps == 0) return text + "; no gaps";
  absl::StrAppend(&text, absl::StrFormat("; %d gaps, the longest %.3f s", statistics.gaps,
                                         statistics.longest_gap_s));
  return text;
}

}  // namespace corbslam::client_agent
