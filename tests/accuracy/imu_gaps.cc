// Measures how far a robot's IMU takes it right while it sees nothing: plays drives, makes pictures
// black for a while again and again, and compares where the robot takes itself to be (docs/pose.md,
// "reckoned") with the truth, from the last frame that had a pose on.
//   imu_gaps [--dark SECONDS] [--seen SECONDS] [--at-least PERCENT] VOCABULARY SOURCE...
// Prints a row for each source, as JSON: the errors in the last dark frame of each gap, how many of
// all errors along an axis are within three of the standard deviations that were said, and local
// maps. Ends with 1 where fewer than PERCENT are, or where nothing was said in a gap.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "client_agent/agent/agent.h"
#include "client_agent/source/recorded_sequence.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/evaluation/ground_truth.h"
#include "slam/evaluation/trajectory.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::ReckonedPose;
using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

struct Options {
  double dark_s = 3;
  double seen_s = 5;  // Before each gap.
  double at_least_percent = 0;
};

struct Gaps {
  std::vector<double> last_errors_m;
  size_t within = 0;
  size_t errors = 0;
  size_t unsaid = 0;  // Dark frames of which nothing was said.
};

// The true camera, rectified as the robot's poses are.
class Truth {
 public:
  Truth(const Trajectory& recorded, const Rigid3d& camera_from_recorded)
      : recorded_(recorded), recorded_from_camera_(camera_from_recorded.Inverse()) {}

  std::optional<Rigid3d> WorldFromCamera(int64_t timestamp_ns) const {
    const auto pairs = AssociateByTime({{timestamp_ns, Rigid3d()}}, recorded_, 3'000'000);
    if (pairs.empty()) return std::nullopt;
    return pairs[0].truth.world_from_camera * recorded_from_camera_;
  }

 private:
  const Trajectory recorded_;
  const Rigid3d recorded_from_camera_;
};

// Returns the error of the camera's place along the axes of the local map.
std::optional<Eigen::Vector3d> ErrorOf(const ReckonedPose& reckoned, int64_t timestamp_ns,
                                       const Truth& truth) {
  const auto now = truth.WorldFromCamera(timestamp_ns);
  const auto before = truth.WorldFromCamera(timestamp_ns - reckoned.motion.since_ns);
  if (!now.has_value() || !before.has_value()) return std::nullopt;
  const Rigid3d local_from_before =
      reckoned.camera_from_local.Inverse() * reckoned.motion.camera_from_previous;
  const Rigid3d local_from_now = local_from_before * before->Inverse() * *now;
  return CameraCentre(reckoned.camera_from_local) - local_from_now.translation;
}

void Count(const TrackingResult& result, const Truth& truth, bool is_last, Gaps& gaps) {
  if (!result.reckoned.has_value()) {
    ++gaps.unsaid;
    return;
  }
  const auto error = ErrorOf(*result.reckoned, result.timestamp_ns, truth);
  if (!error.has_value()) return;
  for (int i = 0; i < 3; ++i) {
    ++gaps.errors;
    const double sigma_m = std::sqrt(result.reckoned->covariance(i, i));
    gaps.within += std::abs((*error)(i)) <= 3 * sigma_m ? 1 : 0;
  }
  if (is_last) gaps.last_errors_m.push_back(error->norm());
}

double Rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

void Darken(SensorImages& images) {
  images.grey = cv::Mat::zeros(images.grey.size(), images.grey.type());
  if (!images.right.empty()) {
    images.right = cv::Mat::zeros(images.right.size(), images.right.type());
  }
  if (!images.depth.empty()) {
    images.depth = cv::Mat::zeros(images.depth.size(), images.depth.type());
  }
}

absl::StatusOr<Gaps> Drive(client_agent::RecordedSequence& sequence, const Truth& truth,
                           const Options& options, Agent& agent) {
  Gaps gaps;
  std::optional<int64_t> start_ns;
  TrackingResult last_dark;
  bool was_dark = false;
  while (true) {
    ASSIGN_OR_RETURN(std::optional<SensorImages> images, sequence.NextImages());
    if (!images.has_value()) return gaps;
    if (!start_ns.has_value()) start_ns = images->timestamp_ns;
    const double time_s = 1e-9 * static_cast<double>(images->timestamp_ns - *start_ns);
    const double phase_s = std::fmod(time_s, options.seen_s + options.dark_s);
    const bool is_dark = phase_s >= options.seen_s;
    if (is_dark) Darken(*images);
    ASSIGN_OR_RETURN(const TrackingResult result, agent.Track(*images));
    // What was said of a frame is counted with the next one, which says whether it was the last.
    if (was_dark) Count(last_dark, truth, !is_dark, gaps);
    was_dark = is_dark;
    last_dark = result;
  }
}

absl::Status Measure(const std::string& source, const Options& options,
                     std::shared_ptr<const Vocabulary> vocabulary) {
  ASSIGN_OR_RETURN(const auto spec, client_agent::ParseSourceSpec(source));
  ASSIGN_OR_RETURN(const auto sequence, client_agent::OpenSource(spec));
  ASSIGN_OR_RETURN(const auto truth, services::ReadGroundTruth(spec));
  if (!truth.has_value()) return absl::NotFoundError("there is no ground truth");
  ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(sequence->calibration()));
  AgentOptions agent_options;
  agent_options.deterministic = true;
  ASSIGN_OR_RETURN(const auto agent, Agent::Create(agent_options, sequence->calibration(),
                                                   std::move(vocabulary), nullptr));
  ASSIGN_OR_RETURN(
      const Gaps gaps,
      Drive(*sequence, Truth(truth->trajectory, recorded.camera_from_recorded), options, *agent));
  const client_agent::AgentStatus status = agent->GetStatus();
  const double within_percent = 100 * static_cast<double>(gaps.within) /
                                std::max<double>(1, static_cast<double>(gaps.errors));
  const std::vector<double>& last = gaps.last_errors_m;
  const nlohmann::json row = {
      {"source", source},
      {"dark_s", options.dark_s},
      {"gaps", last.size()},
      {"rms_m", Rms(last)},
      {"worst_m", last.empty() ? 0 : *std::max_element(last.begin(), last.end())},
      {"within_3_sigma_percent", within_percent},
      {"unsaid_frames", gaps.unsaid},
      {"local_maps", status.local_maps},
      {"bridged", status.bridged}};
  std::printf("%s\n", row.dump().c_str());
  std::fflush(stdout);
  if (options.at_least_percent == 0) return absl::OkStatus();
  if (last.empty() || gaps.unsaid > 0) return absl::OutOfRangeError("nothing was said in a gap");
  if (within_percent >= options.at_least_percent) return absl::OkStatus();
  return absl::OutOfRangeError("too few errors are within three standard deviations");
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  CLI::App app("Measures how far a robot's IMU takes it right while it sees nothing.");
  corbslam::tests::Options options;
  std::string vocabulary_file;
  std::vector<std::string> sources;
  app.add_option("--dark", options.dark_s, "how long each gap is, seconds")
      ->check(CLI::Range(0.1, 5.0));
  app.add_option("--seen", options.seen_s, "how long it sees before each, seconds")
      ->check(CLI::PositiveNumber);
  app.add_option("--at-least", options.at_least_percent,
                 "fail where fewer errors are within three standard deviations, percent")
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("vocabulary", vocabulary_file)->required();
  app.add_option("sources", sources, "as corbslam run takes them")->required();
  CLI11_PARSE(app, argc, argv);
  corbslam::services::RegisterSimulatedSources();
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
