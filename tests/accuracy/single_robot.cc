// Runs one robot over a recorded sequence, without a map store and in the deterministic mode, and
// prints how far its trajectory is from the truth.
//   single_robot SOURCE VOCABULARY TRUTH [FEATURES] [--threads] [--frames]
// SOURCE as in docs ("kitti:DIR?frames=0:100"); TRUTH is a KITTI poses.txt beside a times.txt, or a
// TUM trajectory.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/time/clock.h"
#include "client_agent/agent/agent.h"
#include "client_agent/source/recorded_sequence.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/evaluation/trajectory_error.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::AgentStatus;
using client_agent::AgentTimings;
using client_agent::OpenSource;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::TrajectoryPose;

namespace {

struct Options {
  std::string source;
  std::string vocabulary;
  std::string truth;
  int features = 2000;
  bool threads = false;
  bool frames = false;
};

double MedianOrZero(const std::vector<double>& values) {
  return values.empty() ? 0 : MeanMedian(values);
}

absl::StatusOr<Trajectory> ReadTruth(const std::string& path) {
  if (!absl::EndsWith(path, "poses.txt")) return ReadTumTrajectory(path);
  return ReadKittiTrajectory(path, path.substr(0, path.size() - 9) + "times.txt");
}

Trajectory ToTrajectory(const std::vector<TrajectoryPose>& poses) {
  Trajectory trajectory;
  for (const TrajectoryPose& pose : poses) {
    trajectory.push_back({pose.timestamp_ns, pose.local_from_camera});
  }
  return trajectory;
}

void PrintFrames(const std::vector<PosePair>& pairs, const AbsoluteError& error) {
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d aligned =
        error.truth_from_estimate * pairs[i].estimate.world_from_camera.translation;
    const Eigen::Vector3d off = pairs[i].truth.world_from_camera.rotation.conjugate() *
                                (aligned - pairs[i].truth.world_from_camera.translation);
    std::printf("frame %3zu  off in camera %7.3f %7.3f %7.3f  |%.3f| m\n", i, off.x(), off.y(),
                off.z(), off.norm());
  }
}

absl::Status PrintErrors(const Agent& agent, const Options& options) {
  ASSIGN_OR_RETURN(const Trajectory truth, ReadTruth(options.truth));
  const Trajectory estimate = ToTrajectory(agent.LocalTrajectory());
  std::vector<PosePair> pairs = AssociateByTime(estimate, truth);
  ASSIGN_OR_RETURN(const AbsoluteError all, ComputeAbsoluteError(pairs, Alignment::kSe3));
  if (pairs.size() > 18) {
    pairs.erase(pairs.begin(), pairs.begin() + 15);
  }
  ASSIGN_OR_RETURN(const AbsoluteError later, ComputeAbsoluteError(pairs, Alignment::kSe3));
  ASSIGN_OR_RETURN(const AbsoluteError scaled, ComputeAbsoluteError(pairs, Alignment::kSim3));
  if (options.frames) PrintFrames(pairs, later);
  const AgentStatus status = agent.GetStatus();
  const AgentTimings timings = agent.GetTimings();
  std::printf("ate %.4f m, from frame 15 %.4f m; %d of %d frames tracked, %d local maps\n",
              all.rmse_m, later.rmse_m, status.tracked, status.frames, status.local_maps);
  std::printf("from frame 15 with a scale of its own %.4f m, true size over estimated %.5f\n",
              scaled.rmse_m, scaled.truth_from_estimate.scale);
  std::printf("%d keyframes, %d points, %d loops; tracking %.1f ms, local BA %.1f ms (medians)\n",
              status.keyframes, status.map_points, status.loops_closed,
              MedianOrZero(timings.tracking_ms.values()),
              MedianOrZero(timings.local_ba_ms.values()));
  return absl::OkStatus();
}

void PrintResult(const TrackingResult& result) {
  const Eigen::Vector3d centre = CameraCentre(result.camera_from_local);
  std::printf("time %.3f %s%s %4d points at %.3f %.3f %.3f\n",
              static_cast<double>(result.timestamp_ns) * 1e-9,
              result.state == TrackingState::kTracking ? "tracking" : "lost",
              result.made_keyframe ? ", keyframe," : "", result.points_matched, centre.x(),
              centre.y(), centre.z());
}

absl::Status Run(const Options& options) {
  ASSIGN_OR_RETURN(auto source, OpenSource(options.source));
  ASSIGN_OR_RETURN(auto vocabulary, Vocabulary::Load(options.vocabulary));
  AgentOptions agent_options;
  agent_options.deterministic = !options.threads;
  agent_options.sensor.orb.features = options.features;
  ASSIGN_OR_RETURN(auto agent,
                   Agent::Create(agent_options, source->calibration(), vocabulary, nullptr));
  const absl::Time start = absl::Now();
  while (true) {
    ASSIGN_OR_RETURN(const std::optional<SensorImages> images, source->NextImages());
    if (!images.has_value()) break;
    ASSIGN_OR_RETURN(const TrackingResult result, agent->Track(*images));
    if (options.frames) PrintResult(result);
  }
  RETURN_IF_ERROR(agent->Finish(absl::Minutes(1)));
  std::printf("%.1f s\n", absl::ToDoubleSeconds(absl::Now() - start));
  return PrintErrors(*agent, options);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  if (argc < 4) {
    std::fprintf(stderr,
                 "usage: single_robot SOURCE VOCABULARY TRUTH [FEATURES] [--threads] [--frames]\n");
    return 2;
  }
  corbslam::tests::Options options{argv[1], argv[2], argv[3]};
  for (int i = 4; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--threads") {
      options.threads = true;
    } else if (argument == "--frames") {
      options.frames = true;
    } else {
      options.features = std::atoi(argv[i]);
    }
  }
  const absl::Status status = corbslam::tests::Run(options);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
