// train_vocabulary FOLDER OUTPUT [LEVELS [FEATURES]]: learns a vocabulary from a folder's pictures.
#include <cstdio>
#include <string>

#include "absl/strings/numbers.h"
#include "slam/vocabulary/trainer.h"
#include "slam/vocabulary/vocabulary_file.h"

namespace corbslam {
namespace {

absl::Status Train(const std::string& folder, const std::string& output, int levels, int features) {
  auto paths = ListPictures(folder);
  if (!paths.ok()) return paths.status();
  OrbOptions orb;
  orb.features = features;
  TrainingOptions options;
  options.levels = levels;
  auto tree = TrainFromPictures(
      *paths, orb, options, [](const std::string& step, size_t done, size_t total) {
        std::fprintf(stderr, "\r%s %zu of %zu  ", step.c_str(), done, total);
      });
  if (!tree.ok()) return tree.status();
  if (absl::Status status = WriteVocabulary(*tree, output); !status.ok()) return status;
  auto summary = InspectVocabulary(output);
  if (!summary.ok()) return summary.status();
  std::printf(
      "\n%s: %zu words, %zu nodes, %zu bytes, fingerprint %016llx, weights %.2f %.2f %.2f\n",
      output.c_str(), summary->words, summary->nodes, summary->bytes,
      static_cast<unsigned long long>(summary->fingerprint),
      static_cast<double>(summary->min_weight), static_cast<double>(summary->mean_weight),
      static_cast<double>(summary->max_weight));
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam

int main(int argc, char** argv) {
  int levels = 5;
  int features = 1500;
  if (argc < 3 || argc > 5 || (argc > 3 && !absl::SimpleAtoi(argv[3], &levels)) ||
      (argc > 4 && !absl::SimpleAtoi(argv[4], &features))) {
    std::fprintf(stderr, "usage: %s FOLDER OUTPUT [LEVELS [FEATURES]]\n", argv[0]);
    return 2;
  }
  const absl::Status status = corbslam::Train(argv[1], argv[2], levels, features);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
