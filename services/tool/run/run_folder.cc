#include "services/tool/run/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "absl/algorithm/container.h"
#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/tool/run/plan.h"
#include "slam/util/folders.h"
#include "slam/util/lock_holder.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

// A plan has no more (plan.cc).
constexpr size_t kMostRobots = 100;

// Returns true for the name of a robot of a run.
bool IsRobot(absl::string_view name) {
  for (size_t i = 0; i < kMostRobots; ++i) {
    if (RobotName(i) == name) return true;
  }
  return false;
}

// What is behind a robot's name where it left what it told (services/programs/robot/told_poses.h).
bool IsToldPath(absl::string_view rest) {
  return rest == "told.local.tum" || rest == "told.global.tum";
}

// Returns true for "alpha.local.tum", "alpha.local+2.tum" and the other files of a robot.
bool IsFileOfRobot(absl::string_view file) {
  const size_t dot = file.find('.');
  if (dot == absl::string_view::npos || !IsRobot(file.substr(0, dot))) return false;
  const absl::string_view rest = file.substr(dot + 1);
  if (rest == "map.png" || rest == "near.png" || IsToldPath(rest)) return true;
  const size_t plus = rest.find('+');
  if (plus == absl::string_view::npos) return rest == "local.tum" || rest == "global.tum";
  absl::string_view number = rest.substr(plus + 1, rest.rfind('.') - plus - 1);
  // "+4b" is the second one of that number (trajectory_files.h).
  if (!number.empty() && absl::ascii_islower(number.back())) number.remove_suffix(1);
  size_t ignored = 0;
  return absl::EndsWith(rest, ".tum") && absl::SimpleAtoi(number, &ignored) &&
         (rest.substr(0, plus) == "local" || rest.substr(0, plus) == "global");
}

bool IsResult(const std::string& file) {
  constexpr absl::string_view kReports[] = {"report.json", "report.md", "report.html", "map.png"};
  return absl::c_linear_search(kReports, file) || IsFileOfRobot(file);
}

bool IsLog(const std::string& file) {
  constexpr absl::string_view kLogs[] = {"map_store.log", "fusion_worker.log", "map_viewer.log",
                                         "truth.tum", "missions"};
  const size_t dot = file.find('.');
  const bool is_robots = dot != std::string::npos && IsRobot(file.substr(0, dot)) &&
                         (absl::EndsWith(file, ".log") || absl::EndsWith(file, ".json") ||
                          absl::EndsWith(file, ".map") || IsToldPath(file.substr(dot + 1)));
  return is_robots || absl::c_linear_search(kLogs, file);
}

// Appends the files and folders that `is_ours` knows by their names; what a link leads to, and it
// itself, is none.
template <typename IsOurs>
void CollectIn(const fs::path& folder, const IsOurs& is_ours, std::vector<fs::path>& found) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const fs::file_type type = it->symlink_status(error).type();
    const bool is_plain = type == fs::file_type::regular || type == fs::file_type::directory;
    if (is_plain && is_ours(it->path().filename().string())) found.push_back(it->path());
  }
}

// Returns what a run wrote into the folder, and its robots alone into another one in it.
std::vector<fs::path> CollectOld(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const fs::path& each : {folder, folder / "alone"}) {
    CollectIn(each, IsResult, found);
    CollectIn(each / "logs", IsLog, found);
  }
  return found;
}

// Returns true if the folder has a report of ours: runs of older versions noted nothing.
bool HasReport(const fs::path& folder) {
  std::ifstream file(folder / "report.json");
  const auto json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  return json.is_object() && json.contains("robots") && json.contains("mission");
}

absl::Status Remove(const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    std::error_code error;
    fs::remove_all(file, error);
    if (error) {
      return absl::UnavailableError(
          absl::StrCat("can't remove ", file.string(), ": ", error.message()));
    }
  }
  return absl::OkStatus();
}

// Refuses a folder in which a run would replace what none has written.
absl::Status CheckIsOfRuns(const std::string& folder, const std::string& note) {
  std::error_code error;
  const std::vector<fs::path> old = CollectOld(folder);
  if (old.empty() || fs::exists(note, error) || HasReport(folder)) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("--out ", folder, " has ", old.front().filename().string(),
                   ", which this run would replace and no run wrote: name another folder"));
}

absl::StatusOr<int> LockNote(const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file < 0) {
    return absl::UnavailableError(absl::StrCat("can't write ", path, ": ", std::strerror(errno)));
  }
  if (flock(file, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return file;
  close(file);
  return absl::FailedPreconditionError(absl::StrCat("another run writes to this folder now (", path,
                                                    ": ", DescribeLockHolder(path),
                                                    "): give it another --out"));
}

}  // namespace

RunFolder::~RunFolder() {
  if (lock_ >= 0) close(lock_);
}

absl::StatusOr<RunFolder> RunFolder::Take(const std::string& folder,
                                          const std::string& command_line) {
  const std::string note = folder + "/logs/command.txt";
  RETURN_IF_ERROR(CheckIsOfRuns(folder, note));
  RETURN_IF_ERROR(MakeFolder(folder + "/logs"));
  ASSIGN_OR_RETURN(const int file, LockNote(note));
  RunFolder taken(file);
  RETURN_IF_ERROR(Remove(CollectOld(folder)));
  const std::string line = command_line + "\n";
  const bool good = ftruncate(file, 0) == 0 && lseek(file, 0, SEEK_SET) == 0 &&
                    write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  if (good) return taken;
  return absl::UnavailableError(absl::StrCat("can't write ", note, ": ", std::strerror(errno)));
}

}  // namespace corbslam::services
