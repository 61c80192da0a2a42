// paper_tables OUT.md TITLE=REPORT.json... : the tables of the CORB-SLAM paper (CollaborateCom
// 2017) from the reports of runs, beside the paper's own figures, with accuracy and what each
// process needed. Prints them and writes them to OUT.md.
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {
namespace {

using Json = nlohmann::json;

struct Run {
  std::string title;
  Json report;
};

// Reads "TITLE=PATH".
absl::StatusOr<Run> ReadRun(const std::string& argument) {
  const size_t equals = argument.find('=');
  if (equals == std::string::npos) {
    return absl::InvalidArgumentError(absl::StrCat(argument, ": want TITLE=REPORT.json"));
  }
  const std::string path = argument.substr(equals + 1);
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat("can't open ", path));
  Run run{argument.substr(0, equals), Json::parse(file, nullptr, /*allow_exceptions=*/false)};
  if (run.report.is_discarded()) {
    return absl::InvalidArgumentError(absl::StrCat(path, " is not JSON"));
  }
  return run;
}

std::string Number(const Json& value, int decimals) {
  if (!value.is_number()) return "-";
  return absl::StrFormat("%.*f", decimals, value.get<double>());
}

std::string Row(const std::vector<std::string>& cells) {
  return absl::StrCat("| ", absl::StrJoin(cells, " | "), " |\n");
}
std::string Head(const std::vector<std::string>& cells) {
  return absl::StrCat(Row(cells), Row(std::vector<std::string>(cells.size(), "---")));
}

// Writes count, seconds and megabytes of one kind of item.
std::string Transferred(const Json& item) {
  return absl::StrFormat("%s / %.2f s / %.1f MB", Number(item["count"], 0),
                         item["ms"].get<double>() / 1e3, item["bytes"].get<double>() / 1e6);
}

std::string TransferTable(const std::vector<Run>& runs) {
  std::string table = "Table 1: what robots sent to the store (count / time / bytes)\n\n";
  absl::StrAppend(&table, Head({"run", "full keyframes", "full map points", "light keyframes",
                                "light map points"}));
  absl::StrAppend(&table, Row({"the paper, sequence 00", "937 / 98.15 s", "499681 / 14.02 s",
                               "1083 / 2.57 s", "139418 / 6.05 s"}));
  absl::StrAppend(&table, Row({"the paper, sequence 05", "818 / 89.97 s", "429938 / 12.10 s",
                               "1375 / 2.89 s", "156466 / 7.97 s"}));
  for (const Run& run : runs) {
    const Json& transfer = run.report["transfer"];
    absl::StrAppend(&table, Row({run.title, Transferred(transfer["full_keyframes"]),
                                 Transferred(transfer["full_map_points"]),
                                 Transferred(transfer["light_keyframes"]),
                                 Transferred(transfer["light_map_points"])}));
  }
  return table;
}

std::string Seconds(const Json& ms) {
  return ms.is_number() ? absl::StrFormat("%.3f s", ms.get<double>() / 1e3) : "-";
}

std::string FusionTable(const std::vector<Run>& runs) {
  std::string table = "Table 2: merging local maps and global bundle adjustment\n\n";
  absl::StrAppend(&table, Head({"run", "keyframes in map", "merge", "global BA"}));
  absl::StrAppend(&table, Row({"the paper, sequence 00", "136", "0.535 s", "1.955 s"}));
  absl::StrAppend(&table, Row({"the paper, sequence 05", "456", "2.835 s", "4.535 s"}));
  for (const Run& run : runs) {
    const Json& merges = run.report["merge_ms"];
    const Json& adjustments = run.report["global_ba_ms"];
    for (size_t i = 0; i < adjustments.size(); ++i) {
      // Adjustments between the merges and the last one are left out.
      if (i >= merges.size() && i + 1 < adjustments.size()) continue;
      absl::StrAppend(&table, Row({run.title, Number(adjustments[i]["keyframes"], 0),
                                   i < merges.size() ? Seconds(merges[i]) : "-",
                                   Seconds(adjustments[i]["ms"])}));
    }
  }
  return table;
}

std::string AccuracyTable(const std::vector<Run>& runs) {
  std::string table = "Accuracy (one SE3 alignment a row; KITTI's relative errors)\n\n";
  absl::StrAppend(&table, Head({"run", "who", "frames / tracked", "keyframes", "points", "ATE, m",
                                "t_rel, %", "r_rel, deg/100 m", "loops"}));
  for (const Run& run : runs) {
    for (const Json& robot : run.report["robots"]) {
      absl::StrAppend(
          &table, Row({run.title, robot["name"].get<std::string>(),
                       absl::StrCat(Number(robot["frames"], 0), " / ", Number(robot["tracked"], 0)),
                       Number(robot["keyframes"], 0), Number(robot["map_points"], 0),
                       Number(robot["ate_m"], 3), Number(robot.value("t_rel_percent", Json()), 2),
                       Number(robot.value("r_rel_deg_per_100m", Json()), 2),
                       Number(robot["loops_closed"], 0)}));
    }
    const Json& fused = run.report["fused"];
    absl::StrAppend(
        &table, Row({run.title, absl::StrCat("all, ", Number(fused["islands"], 0), " island"), "",
                     Number(fused["keyframes"], 0), Number(fused["map_points"], 0),
                     Number(fused["ate_m"], 3), Number(fused["t_rel_percent"], 2),
                     Number(fused["r_rel_deg_per_100m"], 2), ""}));
  }
  return table;
}

std::string ResourceTable(const std::vector<Run>& runs) {
  std::string table = "What it took\n\n";
  absl::StrAppend(&table, Head({"run", "process", "peak memory, MB", "processor, s", "wall, s"}));
  for (const Run& run : runs) {
    const std::string wall = Number(run.report["wall_s"], 0);
    for (const Json& robot : run.report["robots"]) {
      absl::StrAppend(
          &table, Row({run.title, robot["name"].get<std::string>(), Number(robot["peak_rss_mb"], 0),
                       Number(robot.value("cpu_s", Json()), 0), wall}));
    }
    for (const auto& [name, server] : run.report["servers"].items()) {
      absl::StrAppend(&table, Row({run.title, name, Number(server["peak_rss_mb"], 0),
                                   Number(server["cpu_s"], 0), wall}));
    }
  }
  return table;
}

absl::Status Write(const std::string& path, const std::vector<std::string>& arguments) {
  std::vector<Run> runs;
  for (const std::string& argument : arguments) {
    ASSIGN_OR_RETURN(Run run, ReadRun(argument));
    runs.push_back(std::move(run));
  }
  const std::string text = absl::StrJoin(
      {TransferTable(runs), FusionTable(runs), AccuracyTable(runs), ResourceTable(runs)}, "\n");
  std::fputs(text.c_str(), stdout);
  std::ofstream file(path);
  file << text;
  if (!file) return absl::UnavailableError(absl::StrCat("can't write ", path));
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: paper_tables OUT.md TITLE=REPORT.json...\n");
    return 2;
  }
  absl::Status status;
  try {
    status = corbslam::tests::Write(argv[1], {argv + 2, argv + argc});
  } catch (const nlohmann::json::exception& error) {
    status = absl::InvalidArgumentError(error.what());
  }
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
