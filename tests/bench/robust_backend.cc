// What wrong overlaps that passed verification do to the map: pose graphs of two to four robots
// with 0 to 50 % of wrong overlaps, each wrong in its own way or in clusters that agree with each
// other (perceptual aliasing), solved in several ways; then whole fusings of two maps with the same
// shares. No pictures. Prints tables and writes JSON.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "slam/verification/testing/synthetic_world.h"
#include "tests/bench/aliased_graph.h"
#include "tests/bench/injected_fusing.h"
#include "tests/bench/robust_solvers.h"

namespace corbslam::tests {
namespace {

using Json = nlohmann::ordered_json;

struct Flags {
  std::vector<int> maps = {2, 3, 4};
  std::vector<int> clusters = {1, 4};
  std::vector<int> wrong_percent = {0, 10, 20, 30, 40, 50};
  std::vector<std::string> solvers;
  int seeds = 10;
  int fusing_seeds = 10;
  std::string json;
};

// Errors of one solver over the seeds.
struct Errors {
  std::vector<double> ate_m;
  std::vector<double> ratio;  // Ratio to the clean run.
  double ms = 0;              // Time of all together.
};

double MedianOrZero(const std::vector<double>& values) {
  return values.empty() ? 0 : MeanMedian(values);
}

double Largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

double Ate_m(const PoseGraphResult& result, const AliasedGraph& graph) {
  std::map<KeyframeId, Rigid3d> estimate;
  for (const auto& [id, pose] : result.camera_from_map) estimate[id] = pose.ToRigid();
  return testing::AteRmse_m(estimate, graph.true_camera_from_world);
}

// Returns the solvers that were asked for, or all if none was.
std::vector<RobustSolver> Chosen(const Flags& flags) {
  std::vector<RobustSolver> chosen = RobustSolvers();
  std::erase_if(chosen, [&](const RobustSolver& solver) {
    return !flags.solvers.empty() && std::find(flags.solvers.begin(), flags.solvers.end(),
                                               solver.name) == flags.solvers.end();
  });
  return chosen;
}

absl::Status SolveAll(const AliasedGraph& graph, const std::vector<RobustSolver>& solvers,
                      std::map<std::string, Errors>& errors) {
  ASSIGN_OR_RETURN(const PoseGraphResult clean, SolveClean(graph));
  const double clean_ate_m = Ate_m(clean, graph);
  errors["clean"].ate_m.push_back(clean_ate_m);
  for (const RobustSolver& solver : solvers) {
    const absl::Time begin = absl::Now();
    ASSIGN_OR_RETURN(const PoseGraphResult result, solver.solve(graph));
    Errors& of_solver = errors[solver.name];
    of_solver.ms += absl::ToDoubleMilliseconds(absl::Now() - begin);
    of_solver.ate_m.push_back(Ate_m(result, graph));
    of_solver.ratio.push_back(of_solver.ate_m.back() / clean_ate_m);
  }
  return absl::OkStatus();
}

void PrintHead(const std::vector<RobustSolver>& solvers) {
  std::printf("| robots | wrong overlaps | clean, m |");
  for (const RobustSolver& solver : solvers) std::printf(" %s |", solver.name.c_str());
  std::printf("\n| --- | --- | --- |");
  for (size_t i = 0; i < solvers.size(); ++i) std::printf(" --- |");
  std::printf("\n");
}

Json PrintRow(int maps, int cluster, int percent, const std::vector<RobustSolver>& solvers,
              std::map<std::string, Errors>& errors) {
  absl::PrintF("| %d | %d %%%s | %.3f |", maps, percent,
               percent == 0 || cluster == 1 ? "" : absl::StrCat(", ", cluster, " agree"),
               MedianOrZero(errors["clean"].ate_m));
  Json row = {{"robots", maps},
              {"wrong_percent", percent},
              {"cluster", cluster},
              {"clean_ate_m", MedianOrZero(errors["clean"].ate_m)}};
  for (const RobustSolver& solver : solvers) {
    const Errors& of_solver = errors[solver.name];
    const double ratio = MedianOrZero(of_solver.ratio);
    absl::PrintF(" %.3f (%.2f, %.2f) |", MedianOrZero(of_solver.ate_m), ratio,
                 Largest(of_solver.ratio));
    row["solvers"][solver.name] = {
        {"ate_m", MedianOrZero(of_solver.ate_m)},
        {"ratio", ratio},
        {"worst_ratio", Largest(of_solver.ratio)},
        {"mean_ms", of_solver.ms / static_cast<double>(of_solver.ratio.size())}};
  }
  std::printf("\n");
  std::fflush(stdout);
  return row;
}

absl::Status CompareSolvers(const Flags& flags, Json& json) {
  std::printf("ATE, m: median (of the ratios to the clean run: median, largest), %d seeds\n\n",
              flags.seeds);
  const std::vector<RobustSolver> solvers = Chosen(flags);
  PrintHead(solvers);
  for (const int maps : flags.maps) {
    for (const int cluster : flags.clusters) {
      for (const int percent : flags.wrong_percent) {
        if (percent == 0 && cluster != flags.clusters.front()) continue;
        std::map<std::string, Errors> errors;
        for (int seed = 1; seed <= flags.seeds; ++seed) {
          AliasedGraphOptions options;
          options.maps = maps;
          options.wrong_share = percent / 100.0;
          options.cluster = cluster;
          options.seed = static_cast<uint64_t>(seed);
          RETURN_IF_ERROR(SolveAll(MakeAliasedGraph(options), solvers, errors));
        }
        json.push_back(PrintRow(maps, cluster, percent, solvers, errors));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CompareFusings(const Flags& flags, Json& json) {
  std::printf(
      "\n| overlaps | wrong | fused | true ones accepted | wrong ones accepted | ATE, m: median | "
      "largest |\n| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const bool at_once : {false, true}) {
    for (const int percent : flags.wrong_percent) {
      InjectionResult sum;
      std::vector<double> ate_m;
      for (int seed = 1; seed <= flags.fusing_seeds; ++seed) {
        ASSIGN_OR_RETURN(
            const InjectionResult result,
            FuseWithInjection({percent / 100.0, at_once, static_cast<uint64_t>(seed)}));
        sum.true_overlaps += result.true_overlaps;
        sum.wrong_overlaps += result.wrong_overlaps;
        sum.true_accepted += result.true_accepted;
        sum.wrong_accepted += result.wrong_accepted;
        if (result.ate_m > 0) ate_m.push_back(result.ate_m);
      }
      absl::PrintF("| %s | %d %% | %d of %d | %d of %d | %d of %d | %.3f | %.3f |\n",
                   at_once ? "at once" : "one by one", percent, ate_m.size(), flags.fusing_seeds,
                   sum.true_accepted, sum.true_overlaps, sum.wrong_accepted, sum.wrong_overlaps,
                   MedianOrZero(ate_m), Largest(ate_m));
      std::fflush(stdout);
      json.push_back({{"at_once", at_once},
                      {"wrong_percent", percent},
                      {"fused", ate_m.size()},
                      {"true_overlaps", sum.true_overlaps},
                      {"true_accepted", sum.true_accepted},
                      {"wrong_overlaps", sum.wrong_overlaps},
                      {"wrong_accepted", sum.wrong_accepted},
                      {"ate_m", MedianOrZero(ate_m)},
                      {"largest_ate_m", Largest(ate_m)}});
    }
  }
  return absl::OkStatus();
}

absl::Status Run(const Flags& flags) {
  Json written = {{"seeds", flags.seeds}, {"graphs", Json::array()}, {"fusings", Json::array()}};
  if (flags.seeds > 0) RETURN_IF_ERROR(CompareSolvers(flags, written["graphs"]));
  if (flags.fusing_seeds > 0) RETURN_IF_ERROR(CompareFusings(flags, written["fusings"]));
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({written.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("Wrong overlaps against robust back-ends", "robust_backend");
  app.add_option("--maps", flags.maps, "Local maps of the pose graphs")
      ->check(CLI::Range(2, 8))
      ->capture_default_str();
  app.add_option("--clusters", flags.clusters, "Wrong overlaps that agree with each other")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_option("--wrong", flags.wrong_percent, "Share of wrong overlaps, percent of all")
      ->check(CLI::Range(0, 90))
      ->capture_default_str();
  std::vector<std::string> names;
  for (const corbslam::tests::RobustSolver& solver : corbslam::tests::RobustSolvers()) {
    names.push_back(solver.name);
  }
  app.add_option("--solvers", flags.solvers, "To compare; all without")
      ->check(CLI::IsMember(names));
  app.add_option("--seeds", flags.seeds, "Pose graphs of each kind; 0: none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--fusing-seeds", flags.fusing_seeds, "Fusings of each kind; 0: none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "robust_backend: %s\n", status.ToString().c_str());
  return 1;
}
