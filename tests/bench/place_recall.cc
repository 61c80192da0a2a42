// place_recall VOCABULARY [OUTPUT.json]: how many places that two robots both saw are recognised
// by words alone. Robot A's pictures and distractors are the database, robot B's are the queries.
// The best keyframe of each query counts as found if it is the same place and its score is above
// that of every wrong best: recall@1 at 100 % precision. CORBSLAM_DATA_DIR names the recordings.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/perturb.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/features/orb_extractor.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "slam/vocabulary/trainer.h"
#include "slam/vocabulary/vocabulary.h"
#include "tests/bench/recognition.h"

namespace corbslam::tests {

using client_agent::Perturb;
using client_agent::Perturbation;

namespace {

constexpr int kFeatures = 2000;

struct Picture {
  std::string path;
  Rigid3d world_from_camera;
};

struct Recordings {
  std::vector<Picture> kitti;
  std::vector<Picture> tum;
  std::vector<Picture> training;
};

struct Experiment {
  std::string name;
  double bar_percent = 0;  // 0: none.
  std::vector<SeenPlace> database;
  std::vector<SeenPlace> queries;
  // Pictures of B that have no place in the database, so that whatever they find is wrong.
  std::vector<SeenPlace> elsewhere;
};

// Makes words of pictures; each sequence is a scene of its own.
class FrameMaker {
 public:
  explicit FrameMaker(std::shared_ptr<const Vocabulary> vocabulary)
      : vocabulary_(std::move(vocabulary)), extractor_(OrbOptions{.features = kFeatures}) {}

  absl::StatusOr<SeenPlace> Make(const Picture& picture, int scene,
                                 const Perturbation& perturbation, uint64_t stream) {
    cv::Mat grey = cv::imread(picture.path, cv::IMREAD_GRAYSCALE);
    if (grey.empty()) return absl::NotFoundError("no picture " + picture.path);
    grey = Perturb(grey, perturbation, stream);
    Features features;
    RETURN_IF_ERROR(extractor_.Extract(grey, features, pyramid_));
    auto words = std::make_shared<Words>(vocabulary_->Transform(features.descriptors));
    return SeenPlace{scene, picture.world_from_camera, std::move(words)};
  }

  // Appends frames first, first + step, ... up to last.
  absl::Status Append(const std::vector<Picture>& pictures, int scene, size_t first, size_t last,
                      size_t step, const Perturbation& perturbation,
                      std::vector<SeenPlace>& frames) {
    for (size_t i = first; i <= last && i < pictures.size(); i += step) {
      ASSIGN_OR_RETURN(SeenPlace frame, Make(pictures[i], scene, perturbation, i));
      frames.push_back(std::move(frame));
    }
    return absl::OkStatus();
  }

 private:
  std::shared_ptr<const Vocabulary> vocabulary_;
  OrbExtractor extractor_;
  ImagePyramid pyramid_;
};

absl::StatusOr<Recordings> FindRecordings(const std::string& folder) {
  Recordings recordings;
  const std::string kitti = folder + "/kitti_00_first201";
  ASSIGN_OR_RETURN(const Trajectory kitti_truth, ReadKittiTrajectory(kitti + "/poses.txt"));
  for (size_t i = 0; i < kitti_truth.size(); ++i) {
    recordings.kitti.push_back(
        {absl::StrFormat("%s/image_0/%06d.png", kitti, i), kitti_truth[i].world_from_camera});
  }
  const std::string tum = folder + "/tum_fr1_xyz_15hz";
  ASSIGN_OR_RETURN(const Trajectory tum_truth, ReadTumTrajectory(tum + "/groundtruth.txt"));
  RETURN_IF_ERROR(
      ForEachLine(tum + "/associated.txt", [&](int, absl::string_view line) -> absl::Status {
        const std::vector<std::string> fields = absl::StrSplit(line, ' ');
        ASSIGN_OR_RETURN(const int64_t time_ns, ParseSeconds(fields[0]));
        const auto pairs = AssociateByTime({{time_ns, Rigid3d()}}, tum_truth);
        const Rigid3d pose = pairs.empty() ? Rigid3d() : pairs[0].truth.world_from_camera;
        recordings.tum.push_back({tum + "/" + fields.at(1), pose});
        return absl::OkStatus();
      }));
  ASSIGN_OR_RETURN(const std::vector<std::string> paths,
                   ListPictures(folder + "/vocabulary_training"));
  for (const std::string& path : paths) recordings.training.push_back({path, Rigid3d()});
  return recordings;
}

// Keeps frames that are nobody's place in `database`.
void KeepElsewhere(const std::vector<SeenPlace>& database, std::vector<SeenPlace>& frames) {
  std::erase_if(frames, [&database](const SeenPlace& frame) {
    return std::any_of(database.begin(), database.end(),
                       [&frame](const SeenPlace& other) { return IsSamePlace(frame, other); });
  });
}

constexpr int kKitti = 0;
constexpr int kTum = 1;
// Each training picture is a scene of its own as far as poses go: never the same place as B's.
constexpr int kTraining = 2;
const Perturbation kNone;
const Perturbation kOtherCamera = {.gamma = 0.8, .noise_sigma = 4.0, .seed = 2};

absl::StatusOr<Experiment> MakeKitti(FrameMaker& maker, const Recordings& recordings,
                                     const std::vector<SeenPlace>& others, bool same_pictures) {
  Experiment experiment{same_pictures ? "KITTI plain split" : "KITTI not the same pictures",
                        same_pictures ? 80.0 : 60.0,
                        others,
                        {},
                        {}};
  const size_t step = same_pictures ? 1 : 2;
  const Perturbation& seen_by_b = same_pictures ? kNone : kOtherCamera;
  const size_t first = same_pictures ? 80 : 81;
  RETURN_IF_ERROR(maker.Append(recordings.kitti, kKitti, 0, 120, step, kNone, experiment.database));
  RETURN_IF_ERROR(
      maker.Append(recordings.kitti, kKitti, first, 120, step, seen_by_b, experiment.queries));
  RETURN_IF_ERROR(
      maker.Append(recordings.kitti, kKitti, 121, 200, step, seen_by_b, experiment.elsewhere));
  KeepElsewhere(experiment.database, experiment.elsewhere);
  return experiment;
}

absl::StatusOr<Experiment> MakeTum(FrameMaker& maker, const Recordings& recordings,
                                   const std::vector<SeenPlace>& others, bool same_pictures) {
  Experiment experiment{
      same_pictures ? "TUM halves" : "TUM not the same pictures", 0, others, {}, {}};
  const size_t step = same_pictures ? 1 : 2;
  RETURN_IF_ERROR(maker.Append(recordings.tum, kTum, 0, 217, step, kNone, experiment.database));
  RETURN_IF_ERROR(maker.Append(recordings.tum, kTum, same_pictures ? 178 : 179, 217, step,
                               same_pictures ? kNone : kOtherCamera, experiment.queries));
  return experiment;
}

absl::StatusOr<std::vector<Experiment>> MakeExperiments(FrameMaker& maker,
                                                        const Recordings& recordings) {
  std::vector<SeenPlace> training;
  RETURN_IF_ERROR(maker.Append(recordings.training, kTraining, 0, recordings.training.size(), 1,
                               kNone, training));
  std::vector<SeenPlace> with_tum = training;
  RETURN_IF_ERROR(maker.Append(recordings.tum, kTum, 0, recordings.tum.size(), 4, kNone, with_tum));
  std::vector<SeenPlace> with_kitti = training;
  RETURN_IF_ERROR(
      maker.Append(recordings.kitti, kKitti, 0, recordings.kitti.size(), 4, kNone, with_kitti));
  std::vector<Experiment> experiments;
  for (const bool same_pictures : {true, false}) {
    ASSIGN_OR_RETURN(Experiment kitti, MakeKitti(maker, recordings, with_tum, same_pictures));
    ASSIGN_OR_RETURN(Experiment tum, MakeTum(maker, recordings, with_kitti, same_pictures));
    experiments.push_back(std::move(kitti));
    experiments.push_back(std::move(tum));
  }
  return experiments;
}

absl::Status Run(const std::string& folder, const std::string& vocabulary_path,
                 const std::string& output) {
  ASSIGN_OR_RETURN(const auto vocabulary, Vocabulary::Load(vocabulary_path));
  ASSIGN_OR_RETURN(const Recordings recordings, FindRecordings(folder));
  FrameMaker maker(vocabulary);
  ASSIGN_OR_RETURN(const std::vector<Experiment> experiments, MakeExperiments(maker, recordings));
  nlohmann::json report = nlohmann::json::array();
  std::printf("%-28s %8s %9s %8s %8s %8s %11s\n", "recall@1, 100 % precision", "queries",
              "database", "right %", "found %", "bar %", "worst wrong");
  for (const Experiment& experiment : experiments) {
    std::vector<SeenPlace> seen_by_b = experiment.queries;
    seen_by_b.insert(seen_by_b.end(), experiment.elsewhere.begin(), experiment.elsewhere.end());
    const Recognition result = Recognise(experiment.database, seen_by_b);
    const double scale = 100.0 / static_cast<double>(experiment.queries.size());
    const double right = scale * static_cast<double>(result.right);
    const double found = scale * static_cast<double>(result.found);
    std::printf("%-28s %8zu %9zu %8.1f %8.1f %8.0f %11.4f\n", experiment.name.c_str(),
                experiment.queries.size(), experiment.database.size(), right, found,
                experiment.bar_percent, result.worst_wrong);
    report.push_back({{"experiment", experiment.name},
                      {"queries", experiment.queries.size()},
                      {"elsewhere", experiment.elsewhere.size()},
                      {"database", experiment.database.size()},
                      {"right_percent", right},
                      {"recall_at_full_precision_percent", found},
                      {"bar_percent", experiment.bar_percent},
                      {"highest_wrong_score", result.worst_wrong}});
  }
  if (output.empty()) return absl::OkStatus();
  return WriteLines({report.dump(2)}, output);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  const char* const folder = std::getenv("CORBSLAM_DATA_DIR");
  if (argc < 2 || argc > 3 || folder == nullptr) {
    std::fprintf(stderr, "usage: CORBSLAM_DATA_DIR=FOLDER %s VOCABULARY [OUTPUT.json]\n", argv[0]);
    return 2;
  }
  const absl::Status status = corbslam::tests::Run(folder, argv[1], argc > 2 ? argv[2] : "");
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
