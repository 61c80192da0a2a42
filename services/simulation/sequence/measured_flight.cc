#include "services/simulation/sequence/measured_flight.h"

#include <cstdint>
#include <optional>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "services/simulation/inertial/gravity.h"
#include "services/simulation/sequence/camera_rig.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

Rigid3d ImuFromCamera(const SimulationSpec& spec) {
  const SimulatedRig rig = MakeRig(spec);
  return std::visit([](const auto& sensor) { return sensor.imu->imu_from_camera; },
                    rig.calibration);
}

// Returns the samples within the way, from whose beginning on they are stamped.
ImuSamples Within(const PoseSequence& way, int64_t begins_ns, const ImuSamples& samples) {
  ImuSamples within;
  for (ImuSample sample : samples) {
    sample.timestamp_ns -= begins_ns;
    if (sample.timestamp_ns < 0 || sample.timestamp_ns > way.duration_ns()) continue;
    within.push_back(sample);
  }
  return within;
}

}  // namespace

absl::StatusOr<MeasuredFlight> ReadMeasuredFlight(const SimulationSpec& spec) {
  ASSIGN_OR_RETURN(Trajectory poses, ReadTumTrajectory(spec.poses));
  const auto named = [&](const absl::Status& status) {
    return absl::InvalidArgumentError(
        absl::StrCat(spec.poses, " and ", spec.imu.file, ": ", status.message()));
  };
  const absl::StatusOr<PoseSequence> of_imu = PoseSequence::Make(poses);
  if (!of_imu.ok()) return named(of_imu.status());
  ImuSamples samples = Within(*of_imu, poses.front().timestamp_ns, *spec.imu.measured);
  const absl::StatusOr<Eigen::Vector3d> gravity =
      EstimateGravity([&](int64_t time_ns) { return of_imu->PoseAt(time_ns); },
                      {0, of_imu->duration_ns()}, samples);
  if (!gravity.ok()) return named(gravity.status());
  const Rigid3d world_from_frame = {
      Eigen::Quaterniond::FromTwoVectors(*gravity, Eigen::Vector3d::UnitY()),
      Eigen::Vector3d::Zero()};
  const Rigid3d imu_from_camera = ImuFromCamera(spec);
  for (StampedPose& pose : poses) {
    pose.world_from_camera = world_from_frame * pose.world_from_camera * imu_from_camera;
  }
  ASSIGN_OR_RETURN(PoseSequence way, PoseSequence::Make(poses));
  return MeasuredFlight{std::move(way), std::move(samples)};
}

}  // namespace corbslam
