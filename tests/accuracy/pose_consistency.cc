// Measures whether the covariances of poses are as large as their errors: plays simulated drives
// and compares the motion between two frames with the truth. The covariance of the
// motion is the sum of both poses' and of what the drift grew by between (docs/pose.md). Where it
// is right, the squared error in units of it is distributed as chi2 with six degrees of freedom
// (Bar-Shalom et al., "Estimation with Applications to Tracking and Navigation", 2001, section 5.4:
// the normalised estimation error squared).
//   pose_consistency [--at-least PERCENT] [--frames COUNT] VOCABULARY SOURCE...
// SOURCE is sim:WORLD?OPTION=VALUE&... with the options of the world, the way and the robot.
// Prints a row for each source and gap, as JSON. Returns 1 where fewer than PERCENT of a row's
// errors are within the 95 % bound.
#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client_agent/agent/agent.h"
#include "client_agent/agent/pose_drift.h"
#include "services/simulation/sequence/simulated_sequence.h"
#include "services/simulation/sequence/simulation_options.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/lie.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

struct Options {
  double at_least_percent = 0;
  size_t frames = 1'000'000;
};

struct Posed {
  size_t frame;
  TrackingResult result;
};

// A covariance in the map's axes as one of a perturbation of camera_from_local on the left: what
// InMapAxes undoes.
Matrix6d InCameraAxes(const TrackingResult& result, const Matrix6d& covariance) {
  const Eigen::Matrix3d turn = result.camera_from_local.rotation.toRotationMatrix();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = -turn;
  J.bottomRightCorner<3, 3>() = -turn;
  return J * covariance * J.transpose();
}

Matrix6d Adjoint(const Rigid3d& motion) {
  const Eigen::Matrix3d turn = motion.rotation.toRotationMatrix();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = turn;
  adjoint.topRightCorner<3, 3>() = Skew(motion.translation) * turn;
  adjoint.bottomRightCorner<3, 3>() = turn;
  return adjoint;
}

// Returns the squared error of the motion from a to b, in units of its covariance.
double NormalisedError(const SimulatedSequence& sequence, const Posed& a, const Posed& b) {
  const Rigid3d estimated = b.result.camera_from_local * a.result.camera_from_local.Inverse();
  const Rigid3d truth =
      sequence.world_from_camera(b.frame).Inverse() * sequence.world_from_camera(a.frame);
  const Matrix6d adjoint = Adjoint(estimated);
  const Matrix6d drift = DriftBetween(a.result, b.result);
  const Matrix6d covariance =
      InCameraAxes(b.result, *b.result.covariance + drift) +
      adjoint * InCameraAxes(a.result, *a.result.covariance) * adjoint.transpose();
  const Vector6d error = LogSE3(truth * estimated.Inverse());
  return error.dot(covariance.ldlt().solve(error));
}

bool IsUsable(const TrackingResult& result) {
  return result.state == TrackingState::kTracking && result.covariance.has_value() &&
         result.drift.has_value();
}

// Returns how many per cent are within the 95 % bound.
double PrintRow(const std::string& source, size_t gap, std::vector<double> errors) {
  if (errors.empty()) return 0;
  double sum = 0;
  int within = 0;
  constexpr double kBound95 = 12.592;  // Of chi2 with six degrees of freedom.
  for (const double error : errors) {
    sum += error;
    within += error <= kBound95 ? 1 : 0;
  }
  const auto count = static_cast<double>(errors.size());
  std::printf(
      "{\"source\": \"%s\", \"gap_frames\": %zu, \"pairs\": %zu, \"mean_nees\": %.2f, "
      "\"median_nees\": %.2f, \"within_95_percent\": %.1f}\n",
      source.c_str(), gap, errors.size(), sum / count, MeanMedian(errors), 100 * within / count);
  std::fflush(stdout);
  return 100 * within / count;
}

absl::StatusOr<std::vector<Posed>> Drive(const SimulatedSequence& sequence, size_t frames,
                                         std::shared_ptr<const Vocabulary> vocabulary) {
  AgentOptions options;
  options.deterministic = true;
  const bool stereo = KindOf(sequence.calibration()) == SensorKind::kStereo;
  options.sensor.orb.features = stereo ? 2000 : 1000;
  ASSIGN_OR_RETURN(const auto agent,
                   Agent::Create(options, sequence.calibration(), vocabulary, nullptr));
  std::vector<Posed> posed;
  for (size_t frame = 0; frame < std::min(frames, sequence.frame_count()); ++frame) {
    ASSIGN_OR_RETURN(const SensorImages images, sequence.Render(frame));
    ASSIGN_OR_RETURN(const TrackingResult result, agent->Track(images));
    if (IsUsable(result)) posed.push_back({frame, result});
  }
  return posed;
}

absl::StatusOr<SimulationSpec> ParseSimulation(const std::string& source) {
  const std::pair<std::string, std::string> parts =
      absl::StrSplit(absl::StripPrefix(source, "sim:"), absl::MaxSplits('?', 1));
  SimulationSpec spec;
  ASSIGN_OR_RETURN(spec.world, ParseSimulatedWorld(parts.first));
  for (const absl::string_view option : absl::StrSplit(parts.second, '&', absl::SkipEmpty())) {
    const std::pair<std::string, std::string> setting =
        absl::StrSplit(option, absl::MaxSplits('=', 1));
    if (!IsSimulationOption(setting.first)) {
      return absl::InvalidArgumentError("no option of simulations: " + setting.first);
    }
    RETURN_IF_ERROR(ApplySimulationOption(setting.first, setting.second, spec));
  }
  RETURN_IF_ERROR(Validate(spec));
  return spec;
}

absl::Status Measure(const std::string& source, const Options& options,
                     std::shared_ptr<const Vocabulary> vocabulary) {
  ASSIGN_OR_RETURN(const SimulationSpec spec, ParseSimulation(source));
  ASSIGN_OR_RETURN(const auto sequence, SimulatedSequence::Make(spec));
  ASSIGN_OR_RETURN(const std::vector<Posed> posed,
                   Drive(*sequence, options.frames, std::move(vocabulary)));
  for (const size_t gap : std::vector<size_t>{1, 3, 10}) {
    std::vector<double> errors;
    for (size_t i = gap; i < posed.size(); ++i) {
      const Posed& a = posed[i - gap];
      const Posed& b = posed[i];
      if (b.frame - a.frame != gap || a.result.epoch != b.result.epoch) continue;
      errors.push_back(NormalisedError(*sequence, a, b));
    }
    const double within = PrintRow(source, gap, std::move(errors));
    if (within < options.at_least_percent) {
      return absl::OutOfRangeError(absl::StrCat(within, " % of the motions over ", gap,
                                                " frames are within their 95 % bounds, fewer than ",
                                                options.at_least_percent,
                                                " %: the covariances say too little"));
    }
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  CLI::App app("Measures whether the covariances of poses are as large as their errors.");
  corbslam::tests::Options options;
  std::string vocabulary_file;
  std::vector<std::string> sources;
  app.add_option("--at-least", options.at_least_percent,
                 "fail where fewer errors of a row are within the 95 % bound, percent")
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--frames", options.frames, "play no more of each drive")
      ->check(CLI::PositiveNumber);
  app.add_option("vocabulary", vocabulary_file)->required();
  app.add_option("sources", sources, "sim:WORLD?OPTION=VALUE&...")->required();
  CLI11_PARSE(app, argc, argv);
  auto vocabulary = corbslam::Vocabulary::Load(vocabulary_file);
  if (!vocabulary.ok()) {
    std::fprintf(stderr, "%s\n", vocabulary.status().ToString().c_str());
    return 1;
  }
  for (const std::string& source : sources) {
    const absl::Status status = corbslam::tests::Measure(source, options, *vocabulary);
    if (status.ok()) continue;
    std::fprintf(stderr, "%s: %s\n", source.c_str(), status.ToString().c_str());
    return 1;
  }
  return 0;
}
