// split_table --folder DIR [--runs N] SPLIT:REFERENCE... : is what several robots map together as
// good as what one maps alone? Reads the reports DIR/NAME/RUN/report.json of `corbslam run`, prints
// tables and writes DIR/splits.md and DIR/splits.json. Exit status 1: a bar is missed by splits
// that have all their runs, as their references have. tests/accuracy/splits.sh makes the runs.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/accuracy/split_runs.h"
#include "tests/accuracy/split_verdict.h"

namespace corbslam::tests {
namespace {

struct Flags {
  std::string folder;
  int runs = 5;
  std::vector<std::string> splits;
};

absl::StatusOr<bool> Tabulate(const Flags& flags) {
  std::vector<SplitVerdict> verdicts;
  for (const std::string& text : flags.splits) {
    const std::pair<std::string, std::string> names = absl::StrSplit(text, absl::MaxSplits(':', 1));
    ASSIGN_OR_RETURN(const std::vector<SplitRun> runs, ReadRuns(flags.folder, names.first));
    ASSIGN_OR_RETURN(const std::vector<SplitRun> reference, ReadRuns(flags.folder, names.second));
    verdicts.push_back(Judge(names.first, names.second, runs, reference, flags.runs));
  }
  const std::string tables = ToMarkdown(verdicts);
  std::fputs(tables.c_str(), stdout);
  RETURN_IF_ERROR(WriteLines({tables}, flags.folder + "/splits.md"));
  RETURN_IF_ERROR(WriteLines({ToJson(verdicts).dump(2)}, flags.folder + "/splits.json"));
  bool all_met = true;
  for (const SplitVerdict& verdict : verdicts) all_met &= !verdict.IsComplete() || verdict.IsMet();
  return all_met;
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("Fused maps beside one robot's", "split_table");
  app.add_option("--folder", flags.folder, "Holds NAME/RUN/report.json")->required();
  app.add_option("--runs", flags.runs, "That each split should have")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("splits", flags.splits, "SPLIT:REFERENCE")->required();
  CLI11_PARSE(app, argc, argv);
  const absl::StatusOr<bool> all_met = corbslam::tests::Tabulate(flags);
  if (all_met.ok()) return *all_met ? 0 : 1;
  std::fprintf(stderr, "split_table: %s\n", all_met.status().ToString().c_str());
  return 2;
}
