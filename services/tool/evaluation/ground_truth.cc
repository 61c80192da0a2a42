#include "services/tool/evaluation/ground_truth.h"

#include <filesystem>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/euroc_calibration.h"
#include "client_agent/source/frame_reader.h"
#include "services/simulated_source/simulated_source.h"
#include "services/simulation/sequence/simulated_sequence.h"
#include "slam/evaluation/trajectory_file.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::EurocRoot;
using client_agent::FormatSourceSpec;
using client_agent::FrameReader;
using client_agent::OpenReader;
using client_agent::ReadEurocCamera;
using client_agent::SourceLayout;
using client_agent::SourceSpec;

namespace {

namespace fs = std::filesystem;

bool Exists(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// Returns the first path that exists, or else the first.
std::string FirstOf(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    if (Exists(path)) return path;
  }
  return paths.front();
}

absl::StatusOr<GroundTruth> FromReading(absl::StatusOr<TrajectoryReading> reading,
                                        const std::string& path) {
  RETURN_IF_ERROR(reading.status());
  if (reading->trajectory.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("ground truth ", path, " holds no pose"));
  }
  return GroundTruth{std::move(reading->trajectory), path,
                     reading->rows_not_finite + reading->rows_repeated, std::move(reading->notes)};
}

// Reads poses.txt. Where a sequence has no times.txt, its times come from the reader that opens it.
absl::StatusOr<TrajectoryReading> ReadKittiPoses(const std::string& path,
                                                 const SourceSpec& source) {
  const std::string times = source.directory + "/times.txt";
  if (!Exists(path) || Exists(times)) return ReadKittiFile(path, times);
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(source));
  std::vector<int64_t> times_ns;
  for (size_t i = 0; i < reader->frame_count(); ++i) times_ns.push_back(reader->timestamp_ns(i));
  return ReadKittiFile(path, times_ns);
}

absl::StatusOr<GroundTruth> ReadKitti(const SourceSpec& source) {
  const std::string& directory = source.directory;
  // The folders of the odometry benchmark itself are sequences/00 and poses/00.txt.
  const fs::path folder = fs::path(directory).lexically_normal();
  const fs::path sequence = folder.has_filename() ? folder : folder.parent_path();
  const std::string path =
      FirstOf({directory + "/poses.txt",
               absl::StrCat(directory, "/../../poses/", sequence.filename().string(), ".txt")});
  return FromReading(ReadKittiPoses(path, source), path);
}

// Returns the names of the truth files in their order. ICL-NUIM calls such a file after the room:
// livingRoom0.gt.freiburg.
std::set<std::string> ListFreiburgFiles(const std::string& directory) {
  std::set<std::string> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    if (absl::EndsWith(entry.path().string(), ".gt.freiburg")) files.insert(entry.path().string());
  }
  return files;
}

absl::StatusOr<GroundTruth> ReadTum(const std::string& directory) {
  const std::string path = directory + "/groundtruth.txt";
  if (Exists(path)) return FromReading(ReadTumFile(path), path);
  const std::set<std::string> freiburg = ListFreiburgFiles(directory);
  if (freiburg.size() > 1) {
    return absl::InvalidArgumentError(
        absl::StrCat(directory, " has ", freiburg.size(),
                     " files of ground truth (*.gt.freiburg): keep the one of this sequence"));
  }
  if (!freiburg.empty()) return FromReading(ReadTumFile(*freiburg.begin()), *freiburg.begin());
  return FromReading(ReadPoseFiles(directory), directory);
}

// Reads one file for each pose. The files have numbers and no times; an option states the pictures'
// rate.
absl::StatusOr<GroundTruth> ReadSevenScenes(const SourceSpec& source) {
  return FromReading(source.opening.fps.has_value()
                         ? ReadPoseFiles(source.directory, *source.opening.fps)
                         : ReadPoseFiles(source.directory),
                     source.directory);
}

absl::StatusOr<GroundTruth> ReadEuroc(const std::string& directory) {
  const std::string root = EurocRoot(directory);
  const std::string path =
      FirstOf({root + "/state_groundtruth_estimate0/data.csv", root + "/mocap0/data.csv"});
  if (!Exists(path)) return absl::NotFoundError(absl::StrCat("cannot open ", path));
  const auto camera = ReadEurocCamera(root + "/cam0/sensor.yaml");
  if (!camera.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("ground truth ", path,
                                                   " is of the body, and where the camera sits on "
                                                   "it isn't known: ",
                                                   camera.status().message()));
  }
  return FromReading(ReadEurocFile(path, camera->body_from_camera), path);
}

absl::StatusOr<GroundTruth> Read(const SourceSpec& source) {
  switch (source.layout) {
    case SourceLayout::kKitti:
      return ReadKitti(source);
    case SourceLayout::kTum:
      return ReadTum(source.directory);
    case SourceLayout::kEuroc:
      return ReadEuroc(source.directory);
    case SourceLayout::kSevenScenes:
      return ReadSevenScenes(source);
    case SourceLayout::kRegistered:
      break;
  }
  const SimulationSpec* simulation = FindSimulation(source);
  if (simulation == nullptr) {
    return absl::NotFoundError(absl::StrCat(FormatSourceSpec(source), " has no ground truth"));
  }
  ASSIGN_OR_RETURN(const std::unique_ptr<SimulatedSequence> sequence,
                   SimulatedSequence::Make(*simulation));
  return GroundTruth{TrueTrajectory(*sequence), "", 0, {}};
}

}  // namespace

absl::StatusOr<std::optional<GroundTruth>> ReadGroundTruth(const SourceSpec& source) {
  absl::StatusOr<GroundTruth> truth = Read(source);
  if (absl::IsNotFound(truth.status()) && FindSimulation(source) == nullptr) return std::nullopt;
  RETURN_IF_ERROR(truth.status());
  return *std::move(truth);
}

absl::StatusOr<Trajectory> TruthOf(const GroundTruth& truth, const SourceSpec& source,
                                   PosesOf poses_of) {
  if (poses_of == PosesOf::kRecordedCamera) return truth.trajectory;
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(source));
  ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(reader->calibration()));
  ASSIGN_OR_RETURN(const auto camera_from_wanted, CameraFromWanted(recorded, poses_of));
  const Rigid3d recorded_from_wanted =
      recorded.camera_from_recorded.Inverse() * camera_from_wanted.value_or(Rigid3d::Identity());
  Trajectory wanted = truth.trajectory;
  for (StampedPose& pose : wanted) {
    pose.world_from_camera = pose.world_from_camera * recorded_from_wanted;
  }
  return wanted;
}

}  // namespace corbslam::services
