#include <string>
#include <vector>

#include "services/simulation/sequence/option_kinds.h"
#include "slam/util/named_values.h"

namespace corbslam {
namespace {

using Spec = SimulationSpec;

constexpr NamedValues<ImuGrade, 3> kGrades = {
    {{"ideal", ImuGrade::kIdeal}, {"good", ImuGrade::kGood}, {"phone", ImuGrade::kPhone}}};

SimulationOption GradeOption() {
  return {"imu", "ideal, good, phone, 0 or a file",
          [](absl::string_view value, Spec& spec) {
            spec.imu.grade = FindNamed(kGrades, value);
            spec.imu.file.clear();
            spec.imu.measured.reset();
            return spec.imu.grade.has_value() || value == "0";
          },
          [](const Spec& spec) {
            return spec.imu.grade ? NameOf(kGrades, *spec.imu.grade) : spec.imu.file;
          }};
}

// Numbers with ':' between them, each from 0 to `most`.
SimulationOption Amounts(absl::string_view name, absl::string_view wants, double most,
                         Numbers (*access)(Spec&)) {
  SimulationOption option = Seconds(name, wants, access);
  option.most = most;
  return option;
}

SimulationOption BiasOption() {
  SimulationOption option =
      Amounts("imu_bias", "GYRO:ACCEL in rad/s and m/s2", 10, [](Spec& s) -> Numbers {
        GyroAccel& bias = s.imu.bias.has_value() ? *s.imu.bias : s.imu.bias.emplace();
        return {&bias.gyro_rps, &bias.accel_mps2};
      });
  option.format = [](const Spec& spec) {  // Absent: the grade's.
    const auto& bias = spec.imu.bias;
    return bias.has_value() ? FormatNumbers({bias->gyro_rps, bias->accel_mps2}) : "";
  };
  return option;
}

// "5:0.2/9:1"
bool ParseGaps(absl::string_view value, std::vector<ImuGap>& gaps) {
  gaps.clear();
  for (const absl::string_view text : absl::StrSplit(value, '/')) {
    ImuGap& gap = gaps.emplace_back();
    if (!ParseNumbers(text, {&gap.from_s, &gap.duration_s})) return false;
  }
  return true;
}

SimulationOption GapsOption() {
  return {"imu_gaps",
          "FROM:DURATION/FROM:DURATION/..., seconds",
          [](absl::string_view value, Spec& spec) { return ParseGaps(value, spec.imu.gaps); },
          [](const Spec& spec) {
            return absl::StrJoin(spec.imu.gaps, "/", [](std::string* out, const ImuGap& gap) {
              absl::StrAppend(out, FormatNumbers({gap.from_s, gap.duration_s}));
            });
          },
          [](const Spec& spec) {
            std::vector<double> numbers;
            for (const ImuGap& gap : spec.imu.gaps) {
              numbers.insert(numbers.end(), {gap.from_s, gap.duration_s});
            }
            return numbers;
          },
          0,
          1e6};
}

}  // namespace

std::vector<SimulationOption> ImuOptions() {
  return {
      GradeOption(),
      Real("imu_rate", 20, 1000, [](Spec& s) -> double& { return s.imu.rate_hz; }),
      BiasOption(),
      Real("imu_late_s", -1, 1, [](Spec& s) -> double& { return s.imu.late_s; }),
      Amounts("imu_vibration", "HERTZ:GYRO:ACCEL in Hz, rad/s and m/s2", 10'000,
              [](Spec& s) -> Numbers {
                ImuVibration& vibration = s.imu.vibration;
                return {&vibration.frequency_hz, &vibration.amplitude.gyro_rps,
                        &vibration.amplitude.accel_mps2};
              }),
      Amounts("imu_warming", "GYRO:ACCEL:SECONDS, rad/s, m/s2 and s", 1e5,
              [](Spec& s) -> Numbers {
                ImuWarming& warming = s.imu.warming;
                return {&warming.change.gyro_rps, &warming.change.accel_mps2, &warming.within_s};
              }),
      Amounts("imu_range", "GYRO:ACCEL in rad/s and m/s2; 0 is any", 1e5,
              [](Spec& s) -> Numbers {
                return {&s.imu.range.gyro_rps, &s.imu.range.accel_mps2};
              }),
      GapsOption()};
}

}  // namespace corbslam
