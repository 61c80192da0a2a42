#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/progress.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/trainer.h"
#include "slam/vocabulary/vocabulary.h"
#include "slam/vocabulary/vocabulary_file.h"

namespace corbslam::services {
namespace {

struct TrainArguments {
  std::vector<std::string> folders;
  std::string out;
  int features = 1500;
  TrainingOptions training;
};

absl::Status Train(const TrainArguments& arguments) {
  std::vector<std::string> paths;
  for (const std::string& folder : arguments.folders) {
    ASSIGN_OR_RETURN(const std::vector<std::string> listed, ListPictures(folder));
    paths.insert(paths.end(), listed.begin(), listed.end());
  }
  OrbOptions orb;
  orb.features = arguments.features;
  RETURN_IF_ERROR(orb.Validate());
  RETURN_IF_ERROR(arguments.training.Validate());
  ProgressLine line;
  const TrainingProgress progress = [&line](const std::string& step, size_t done, size_t total) {
    line.Tell(absl::StrCat(step, " ", done, " of ", total));
  };
  ASSIGN_OR_RETURN(const VocabularyTree tree,
                   TrainFromPictures(paths, orb, arguments.training, progress));
  RETURN_IF_ERROR(WriteVocabulary(tree, arguments.out));
  PrintResult("", {{"file", arguments.out}, {"pictures", paths.size()}});
  return absl::OkStatus();
}

absl::Status Inspect(const std::string& path) {
  ASSIGN_OR_RETURN(const VocabularySummary summary, InspectVocabulary(path));
  PrintResult(
      absl::StrFormat("branching %d, levels %d, direct index at level %d (%d groups)\n"
                      "nodes %d, words %d, weights %.3f to %.3f (mean %.3f)\n"
                      "%d bytes, fingerprint %016x\n",
                      summary.branching, summary.levels, summary.direct_level, summary.direct_nodes,
                      summary.nodes, summary.words, summary.min_weight, summary.max_weight,
                      summary.mean_weight, summary.bytes, summary.fingerprint),
      {{"branching", summary.branching},
       {"levels", summary.levels},
       {"direct_level", summary.direct_level},
       {"direct_nodes", summary.direct_nodes},
       {"nodes", summary.nodes},
       {"words", summary.words},
       {"min_weight", summary.min_weight},
       {"max_weight", summary.max_weight},
       {"mean_weight", summary.mean_weight},
       {"bytes", summary.bytes},
       {"fingerprint", absl::StrFormat("%016x", summary.fingerprint)}});
  return absl::OkStatus();
}

VocabularyTree CopyTree(const VocabularyTreeView& view) {
  VocabularyTree tree;
  tree.branching = view.branching;
  tree.levels = view.levels;
  tree.direct_level = view.direct_level;
  tree.descriptors.assign(view.descriptors.begin(), view.descriptors.end());
  tree.first_child.assign(view.first_child.begin(), view.first_child.end());
  tree.weights.assign(view.weights.begin(), view.weights.end());
  return tree;
}

absl::StatusOr<VocabularyTree> ReadEither(const std::string& path) {
  if (absl::EndsWith(path, ".txt")) return ReadTextVocabulary(path);
  ASSIGN_OR_RETURN(const std::shared_ptr<const Vocabulary> vocabulary, Vocabulary::Load(path));
  RETURN_IF_ERROR(vocabulary->Verify());
  return CopyTree(vocabulary->tree());
}

absl::Status Convert(const std::string& from, const std::string& to) {
  ASSIGN_OR_RETURN(const VocabularyTree tree, ReadEither(from));
  RETURN_IF_ERROR(absl::EndsWith(to, ".txt") ? WriteTextVocabulary(tree, to)
                                             : WriteVocabulary(tree, to));
  PrintResult("", {{"file", to}});
  return absl::OkStatus();
}

void AddTrain(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<TrainArguments>();
  CLI::App* train = app.add_subcommand("train", "Learn a vocabulary from pictures");
  train->add_option("folders", arguments->folders, "Folders of png, jpg and pgm files")->required();
  train->add_option("--out", arguments->out, "The vocabulary to write")->required();
  train->add_option("--features", arguments->features, "Features a picture")
      ->check(CLI::Range(1, 20000))
      ->capture_default_str();
  train->add_option("--branching", arguments->training.branching)
      ->check(CLI::Range(2, 256))
      ->capture_default_str();
  train->add_option("--levels", arguments->training.levels)
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  train->add_option("--seed", arguments->training.seed)->capture_default_str();
  train->add_option("--threads", arguments->training.threads)
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  train->callback([arguments, &chosen] { chosen = [arguments] { return Train(*arguments); }; });
}

}  // namespace

void AddVocabularyCommand(CLI::App& app, Command& chosen) {
  CLI::App* vocabulary = app.add_subcommand("vocabulary", "Make and look at vocabularies");
  vocabulary->require_subcommand(1);
  AddTrain(*vocabulary, chosen);
  auto path = std::make_shared<std::string>();
  CLI::App* inspect = vocabulary->add_subcommand("inspect", "Verify a vocabulary and describe it");
  inspect->add_option("vocabulary", *path)->required();
  inspect->callback([path, &chosen] { chosen = [path] { return Inspect(*path); }; });
  auto to = std::make_shared<std::string>();
  CLI::App* convert = vocabulary->add_subcommand(
      "convert", "Between our form and ORB-SLAM2's text, which ends in .txt");
  convert->add_option("from", *path)->required();
  convert->add_option("to", *to)->required();
  convert->callback([path, to, &chosen] { chosen = [path, to] { return Convert(*path, *to); }; });
}

}  // namespace corbslam::services
