// Asks a map where pictures were taken, and says of their camera what is not so. A pose that comes
// all the same must be within five of its own standard deviations of where the picture was taken;
// with the right camera it must come.
//   wrong_cameras [--requests COUNT] [--seed SEED] [--frames COUNT] VOCABULARY SOURCE...
// A robot maps each source in this process. Then COUNT requests with wrong cameras, and up to as
// many with the right one, of frames that became no keyframes, as a worker answers them (places by
// words, two at a time, LocateFrame). What is right is where the robot had the frame in its own
// map. Prints a row for each source and kind, as JSON; ends with 1 where a pose was wrong by more
// than it says.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "client_agent/agent/agent.h"
#include "client_agent/source/recorded_sequence.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/geometry/lie.h"
#include "slam/place/candidate_groups.h"
#include "slam/place/keyframe_database.h"
#include "slam/sensor/picture_features.h"
#include "slam/util/status_macros.h"
#include "slam/verification/frame_location.h"
#include "tests/accuracy/said_cameras.h"

namespace corbslam::tests {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

constexpr int kFeatures = 1000;  // As a worker finds in a picture.
constexpr double kMaxSigmas = 5;

struct Options {
  size_t requests = 250;
  size_t frames = 1'000'000;
  uint64_t seed = 1;
  bool verbose = false;
};

struct Taken {
  int64_t timestamp_ns = 0;
  cv::Mat grey;
  Rigid3d map_from_camera;  // Of the camera as it recorded.
};

// Answers to one kind of question.
struct Row {
  size_t asked = 0;
  size_t located = 0;
  size_t beyond = 0;  // Wrong by more than kMaxSigmas.
  double worst_sigmas = 0;
  double worst_m = 0;
  std::vector<double> sigmas_m;
  std::vector<double> errors_m;
  std::map<std::string, int> stages;
};

double MiddleOf(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

nlohmann::json ToJson(const std::string& source, const std::string& kind, const Row& row) {
  return {{"source", source},
          {"camera", kind},
          {"asked", row.asked},
          {"located", row.located},
          {"beyond_5_sigma", row.beyond},
          {"worst_sigmas", row.worst_sigmas},
          {"worst_m", row.worst_m},
          {"median_m", MiddleOf(row.errors_m)},
          {"median_sigma_m", MiddleOf(row.sigmas_m)},
          {"stages", row.stages}};
}

class Asker {
 public:
  Asker(Options options, std::shared_ptr<const Vocabulary> vocabulary)
      : options_(options), vocabulary_(std::move(vocabulary)) {}

  absl::Status MapDrive(const std::string& source) {
    ASSIGN_OR_RETURN(const auto stream, client_agent::OpenSource(source));
    ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(stream->calibration()));
    camera_ = recorded.lens;
    AgentOptions options;
    options.deterministic = true;
    const bool is_stereo = KindOf(stream->calibration()) == SensorKind::kStereo;
    options.sensor.orb.features = is_stereo ? 2000 : 1000;
    ASSIGN_OR_RETURN(const auto agent,
                     Agent::Create(options, stream->calibration(), vocabulary_, nullptr));
    for (size_t i = 0; i < options_.frames; ++i) {
      ASSIGN_OR_RETURN(const std::optional<SensorImages> images, stream->NextImages());
      if (!images.has_value()) break;
      ASSIGN_OR_RETURN(const TrackingResult result, agent->Track(*images));
      if (result.state != TrackingState::kTracking || result.made_keyframe) continue;
      taken_.push_back({images->timestamp_ns, images->grey.clone(), {}});
    }
    map_ = agent->CopyMap();
    for (const auto& [id, keyframe] : map_.keyframes()) places_.Add(id, keyframe.words);
    return FindTruth(*agent, recorded.camera_from_recorded);
  }

  absl::StatusOr<Row> AskRightly() {
    Row row;
    const size_t each = std::max<size_t>(1, taken_.size() / std::max<size_t>(1, options_.requests));
    for (size_t i = 0; i < taken_.size(); i += each) {
      const Taken& taken = taken_[i];
      RETURN_IF_ERROR(
          Ask(taken, {.grey = taken.grey, .camera = camera_, .said_from_true = {}}, "right", row));
    }
    return row;
  }

  absl::StatusOr<std::vector<Row>> AskWrongly() {
    std::vector<Row> rows(WrongKinds().size());
    std::mt19937_64 random(options_.seed);
    for (size_t i = 0; i < options_.requests; ++i) {
      const size_t kind = i % rows.size();
      const Taken& taken = taken_[random() % taken_.size()];
      RETURN_IF_ERROR(Ask(taken, SayWrongly(kind, taken.grey, camera_, random), WrongKinds()[kind],
                          rows[kind]));
    }
    return rows;
  }

 private:
  absl::Status FindTruth(const Agent& agent, const Rigid3d& camera_from_recorded) {
    std::map<int64_t, Rigid3d> poses;
    for (const client_agent::TrajectoryPose& pose : agent.LocalTrajectory()) {
      if (pose.local_map != agent.GetStatus().local_map) continue;
      poses[pose.timestamp_ns] = pose.local_from_camera * camera_from_recorded;
    }
    std::erase_if(taken_, [&](const Taken& taken) { return !poses.contains(taken.timestamp_ns); });
    for (Taken& taken : taken_) taken.map_from_camera = poses.at(taken.timestamp_ns);
    if (taken_.empty()) return absl::NotFoundError("no frame was tracked beside the keyframes");
    return absl::OkStatus();
  }

  // As the store chooses places, and asks workers of two at a time.
  LocateFrameResult Locate(const PictureFeatures& picture) const {
    constexpr size_t kMaxPlaces = 12;
    constexpr size_t kPlacesOfRequest = 2;
    LocateFrameRequest request;
    request.view = map_;
    request.frame.payload = MakeKeyframePayload(
        {}, 0, 0, std::make_shared<const Camera>(picture.camera), Features(picture.features));
    request.frame.points.resize(request.frame.keypoints().size());
    request.frame.words =
        std::make_shared<const Words>(vocabulary_->Transform(request.frame.descriptors()));
    const std::vector<CandidateGroup> places =
        GroupByCovisibility(map_, places_.Query(request.frame.words->bag), kMaxPlaces);
    LocateFrameResult farthest;
    for (size_t i = 0; i < places.size(); ++i) {
      request.candidates.push_back({places[i].best.id, places[i].best.shared_words});
      if (request.candidates.size() < kPlacesOfRequest && i + 1 < places.size()) continue;
      LocateFrameResult result = LocateFrame(request);
      request.candidates.clear();
      const bool ends = result.stage == LocateStage::kLocated || result.fitting_camera.has_value();
      if (ends || GotFarther(result, farthest)) farthest = std::move(result);
      if (ends) break;
    }
    return farthest;
  }

  absl::Status Ask(const Taken& taken, const SaidPicture& said, const std::string& kind,
                   Row& row) const {
    ++row.asked;
    const auto picture = FindPictureFeatures(said.grey, said.camera, kFeatures);
    if (absl::IsInvalidArgument(picture.status())) {
      ++row.stages["refused"];
      return absl::OkStatus();
    }
    RETURN_IF_ERROR(picture.status());
    const LocateFrameResult answer = Locate(*picture);
    ++row.stages[answer.fitting_camera.has_value() ? "ANOTHER_CAMERA" : ToString(answer.stage)];
    if (answer.stage == LocateStage::kLocated) Judge(taken, said, kind, answer, row);
    return absl::OkStatus();
  }

  void Judge(const Taken& taken, const SaidPicture& said, const std::string& kind,
             const LocateFrameResult& answer, Row& row) const {
    ++row.located;
    const Rigid3d truth = taken.map_from_camera * said.said_from_true.Inverse();
    const Rigid3d found = answer.camera_from_map.Inverse();
    const double off_m = (found.translation - truth.translation).norm();
    const double off_rad = RotationAngle(found.rotation * truth.rotation.conjugate());
    double sigma_m = 0;
    double sigmas = std::numeric_limits<double>::infinity();
    if (answer.covariance.has_value() && !said.has_no_place) {
      sigma_m = std::sqrt(answer.covariance->topLeftCorner<3, 3>().trace());
      const double sigma_rad = std::sqrt(answer.covariance->bottomRightCorner<3, 3>().trace());
      sigmas = std::max(off_m / sigma_m, off_rad / sigma_rad);
    }
    row.worst_sigmas = std::max(row.worst_sigmas, sigmas);
    row.worst_m = std::max(row.worst_m, off_m);
    row.errors_m.push_back(off_m);
    row.sigmas_m.push_back(sigma_m);
    if (!(sigmas <= kMaxSigmas)) ++row.beyond;
    if (!options_.verbose && sigmas <= kMaxSigmas) return;
    std::fprintf(stderr,
                 "%s, fx %.1f fy %.1f cx %.1f cy %.1f, %s, of %dx%d: %.3f m, %.2f degrees off, "
                 "sigma %.3f m, %.1f sigmas, %d inliers of %d\n",
                 kind.c_str(), said.camera.fx_px, said.camera.fy_px, said.camera.cx_px,
                 said.camera.cy_px, DescribeLens(said.camera.lens).c_str(), said.grey.cols,
                 said.grey.rows, off_m, 180 / 3.14159265 * off_rad, sigma_m, sigmas, answer.inliers,
                 answer.visible_points);
  }

  const Options options_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  RawCamera camera_;
  Map map_;
  KeyframeDatabase places_;
  std::vector<Taken> taken_;
};

// Returns how many poses were wrong by more than they say.
absl::StatusOr<size_t> Measure(const std::string& source, const Options& options,
                               std::shared_ptr<const Vocabulary> vocabulary) {
  Asker asker(options, std::move(vocabulary));
  RETURN_IF_ERROR(asker.MapDrive(source));
  ASSIGN_OR_RETURN(const Row right, asker.AskRightly());
  std::printf("%s\n", ToJson(source, "right", right).dump().c_str());
  std::fflush(stdout);
  ASSIGN_OR_RETURN(const std::vector<Row> rows, asker.AskWrongly());
  size_t beyond = right.beyond;
  for (size_t kind = 0; kind < rows.size(); ++kind) {
    std::printf("%s\n", ToJson(source, WrongKinds()[kind], rows[kind]).dump().c_str());
    beyond += rows[kind].beyond;
  }
  std::fflush(stdout);
  return beyond;
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  CLI::App app("Asks where pictures were taken, with cameras that did not take them.");
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Options options;
  std::string vocabulary_file;
  std::vector<std::string> sources;
  app.add_option("--requests", options.requests, "with wrong cameras, of each source");
  app.add_option("--frames", options.frames, "play no more of each source");
  app.add_option("--seed", options.seed, "of the cameras");
  app.add_flag("--verbose", options.verbose, "print each pose on standard error");
  app.add_option("vocabulary", vocabulary_file)->required();
  app.add_option("sources", sources, "as client_agent's --source")->required();
  CLI11_PARSE(app, argc, argv);
  auto vocabulary = corbslam::Vocabulary::Load(vocabulary_file);
  if (!vocabulary.ok()) {
    std::fprintf(stderr, "%s\n", vocabulary.status().ToString().c_str());
    return 1;
  }
  size_t beyond = 0;
  for (const std::string& source : sources) {
    const auto measured = corbslam::tests::Measure(source, options, *vocabulary);
    if (!measured.ok()) {
      std::fprintf(stderr, "%s: %s\n", source.c_str(), measured.status().ToString().c_str());
      return 1;
    }
    beyond += *measured;
  }
  if (beyond == 0) return 0;
  std::fprintf(stderr, "%zu poses are wrong by more than 5 of their standard deviations\n", beyond);
  return 1;
}
