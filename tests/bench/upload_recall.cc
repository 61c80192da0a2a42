// What leaving features out of the upload costs in recognised places: two robots, alone and in
// lockstep, upload keyframes with all features, with those that see a map point, and with so many;
// the second one's keyframes are sought among the first one's by words alone, as the store does.
// recognition.h says what counts.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/source_spec.h"
#include "services/convert/batch_bytes.h"
#include "services/programs/default_vocabulary.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/evaluation/ground_truth.h"
#include "slam/evaluation/trajectory.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"
#include "tests/bench/recognition.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

using client_agent::FeatureSelection;
using client_agent::ParseFeatureSelection;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using services::DefaultVocabularyPath;
using services::EncodeBatch;
using services::GroundTruth;
using services::ReadGroundTruth;

namespace {

struct Flags {
  std::string first;
  std::string second;
  std::vector<std::string> features = {"all", "mapped", "1500", "1000", "500"};
};

struct Upload {
  std::vector<SeenPlace> places;
  size_t features = 0;
  size_t bytes = 0;
};

// Makes what the store has in the end: keyframes that were removed again are left out.
absl::StatusOr<Upload> MakeUpload(const std::string& source, const FeatureSelection& selection,
                                  const std::shared_ptr<const Vocabulary>& vocabulary) {
  ASSIGN_OR_RETURN(const SourceSpec spec, ParseSourceSpec(source));
  ASSIGN_OR_RETURN(const std::optional<GroundTruth> truth, ReadGroundTruth(spec));
  if (!truth.has_value()) {
    return absl::InvalidArgumentError(absl::StrCat(source, " has no ground truth"));
  }
  ASSIGN_OR_RETURN(const RecordedUploads batches, RecordUploads(source, vocabulary, selection));
  Upload upload;
  std::set<KeyframeId> removed;
  for (const MapUpdateBatch& batch : batches) {
    upload.bytes += EncodeBatch(batch).size();
    for (const KeyframeRemoval& removal : batch.removed_keyframes) removed.insert(removal.id);
  }
  for (const MapUpdateBatch& batch : batches) {
    for (const FullKeyframe& keyframe : batch.full_keyframes) {
      const KeyframePayload& payload = *keyframe.payload;
      const auto pairs = AssociateByTime({{payload.timestamp_ns, Rigid3d()}}, truth->trajectory);
      if (removed.contains(payload.id) || pairs.empty()) continue;
      upload.features += payload.features.keypoints.size();
      upload.places.push_back(
          {0, pairs[0].truth.world_from_camera,
           std::make_shared<const Words>(vocabulary->Transform(payload.features.descriptors))});
    }
  }
  if (upload.places.empty()) return absl::InternalError(absl::StrCat(source, ": nothing went up"));
  return upload;
}

// Counts the second robot's places where the first robot was, too.
size_t CountPlacesOfBoth(const Upload& second, const Upload& first) {
  return static_cast<size_t>(std::ranges::count_if(second.places, [&](const SeenPlace& place) {
    return std::ranges::any_of(first.places,
                               [&](const SeenPlace& other) { return IsSamePlace(place, other); });
  }));
}

double Percent(size_t part, size_t whole) {
  return whole == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const Vocabulary> vocabulary,
                   Vocabulary::Load(DefaultVocabularyPath()));
  std::printf(
      "| features | keyframes | features of one | MB up | places that both saw | best is "
      "right, %% | at 100 %% precision, %% |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const std::string& text : flags.features) {
    ASSIGN_OR_RETURN(const FeatureSelection selection, ParseFeatureSelection(text));
    ASSIGN_OR_RETURN(const Upload first, MakeUpload(flags.first, selection, vocabulary));
    ASSIGN_OR_RETURN(const Upload second, MakeUpload(flags.second, selection, vocabulary));
    const size_t keyframes = first.places.size() + second.places.size();
    const size_t both = CountPlacesOfBoth(second, first);
    const Recognition recognition = Recognise(first.places, second.places);
    std::printf("| %s | %zu | %zu | %.2f | %zu | %.1f | %.1f |\n", text.c_str(), keyframes,
                (first.features + second.features) / keyframes,
                1e-6 * static_cast<double>(first.bytes + second.bytes), both,
                Percent(recognition.right, both), Percent(recognition.found, both));
    std::fflush(stdout);
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("Places that are recognised among features that were left out", "upload_recall");
  app.add_option("--first", flags.first, "What the first robot has seen: kitti:DIR, ...")
      ->required();
  app.add_option("--second", flags.second, "... and the second one")->required();
  app.add_option("--features", flags.features, "As client_agent --upload features=")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "upload_recall: %s\n", status.ToString().c_str());
  return 1;
}
