#include "services/tool/doctor/local_checks.h"

#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/live_opening.h"
#include "client_agent/source_checks/source_checks.h"
#include "services/command_line/secrets.h"
#include "services/programs/checks.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::DescribeInLines;
using client_agent::FindingLevel;
using client_agent::FrameReader;
using client_agent::InspectSource;
using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::SampleOptions;
using client_agent::SourceFinding;
using client_agent::SourceFindings;
using client_agent::SourceSpec;

namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMiB = uint64_t{1} << 20;
constexpr uint64_t kLittle = 1024 * kMiB;
constexpr uint64_t kTooLittle = 64 * kMiB;

// Returns when the program was written to this disk.
absl::StatusOr<absl::Time> TimeOfProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return absl::UnavailableError("/proc/self/exe can't be read");
  const auto written = fs::last_write_time(program, error);
  if (error) return absl::UnavailableError(program.string() + " can't be read");
  return absl::FromChrono(std::chrono::file_clock::to_sys(written));
}

// Returns true if the kernel says that something corrects its clock.
bool IsSynchronised() {
  timex state = {};
  return adjtimex(&state) != TIME_ERROR;
}

constexpr char kSource[] = "source";
// For the largest pictures this sample takes some seconds of decoding.
constexpr SampleOptions kThorough = {.places = 16, .stereo_row = 3, .rgbd_row = 5};

Findings LookInto(const FrameReader& reader, const SourceSpec& spec, bool strict) {
  Findings findings;
  for (const auto& [name, value] : DescribeInLines(reader.description())) {
    findings.push_back({Level::kOk, kSource, absl::StrCat(name, ": ", value), ""});
  }
  SourceFindings all = InspectSource(reader, spec, kThorough);
  // What a late camera shows besides follows from it, and nothing right comes of such pictures.
  const auto is_late = [](const SourceFinding& found) { return found.code == "pair-late"; };
  std::stable_partition(all.begin(), all.end(), is_late);
  for (const SourceFinding& found : all) {
    const bool fails = strict || found.level == FindingLevel::kError || is_late(found);
    findings.push_back({fails ? Level::kFail : Level::kWarn, kSource, found.text,
                        absl::StrCat("look up ", found.code, " in docs/sources.md")});
  }
  return findings;
}

Finding SourceFailure(const std::string& source, const absl::Status& status) {
  return {Level::kFail, kSource, absl::StrCat(source, ": ", status.message()),
          "docs/sources.md says what each layout's files are"};
}

bool CanMakeFile(const fs::path& folder) {
  std::string name = (folder / ".corbslam_doctor_XXXXXX").string();
  const int file = mkstemp(name.data());
  if (file < 0) return false;
  const bool good = write(file, "x", 1) == 1;
  close(file);
  unlink(name.c_str());
  return good;
}

Finding CheckSpace(const fs::path& folder) {
  std::error_code error;
  const uint64_t free = fs::space(folder, error).available;
  if (error) {
    return {Level::kFail, "free space", absl::StrCat(folder.string(), ": ", error.message()),
            "give --data-dir a folder of this machine's disks"};
  }
  const std::string text =
      absl::StrFormat("%.1f GB free at %s", 1e-9 * static_cast<double>(free), folder.string());
  if (free >= kLittle) return {Level::kOk, "free space", text, ""};
  return {free < kTooLittle ? Level::kFail : Level::kWarn, "free space", text,
          "make room: with less than --min-free-mb (64) a store tells robots to wait"};
}

}  // namespace

Findings CheckClock(absl::Time now) {
  Findings findings;
  const absl::StatusOr<absl::Time> made = TimeOfProgram();
  const std::string text = absl::FormatTime(absl::RFC3339_sec, now, absl::UTCTimeZone());
  if (made.ok() && now < *made) {
    findings.push_back({Level::kFail, "clock",
                        absl::StrCat(text, ", which is before this program was installed"),
                        "set the clock (timedatectl); certificates and tokens are judged by it"});
  } else {
    findings.push_back({Level::kOk, "clock", text, ""});
  }
  if (!IsSynchronised()) {
    findings.push_back({Level::kWarn, "clock", "the kernel's clock is not synchronised",
                        "run an NTP client (systemd-timesyncd, chrony)"});
  }
  return findings;
}

Finding CheckVocabularyFile(const std::string& path) {
  const absl::Status status = CheckVocabulary(path);
  if (status.ok()) return {Level::kOk, "vocabulary", path, ""};
  return {Level::kFail, "vocabulary", std::string(status.message()),
          "reinstall corbslam-common, or name another by --vocabulary"};
}

Findings CheckDataFolder(const std::string& path) {
  const fs::path folder = NearestThere(path);
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return {{Level::kFail, "data folder", absl::StrCat(folder.string(), " is no folder"),
             "give --data-dir a folder"}};
  }
  if (!CanMakeFile(folder)) {
    return {{Level::kFail, "data folder", absl::StrCat("can't write to ", folder.string()),
             "chown it to whoever runs the store, and see that its disk is mounted writable"}};
  }
  return {{Level::kOk, "data folder", absl::StrCat(folder.string(), " can be written to"), ""},
          CheckSpace(folder)};
}

Findings CheckSource(const std::string& source, bool strict) {
  const absl::StatusOr<SourceSpec> spec = ParseSourceSpec(source);
  if (!spec.ok()) return {SourceFailure(source, spec.status())};
  if (client_agent::IsLive(*spec)) {
    return {{Level::kWarn, kSource,
             absl::StrCat(HideSecrets(source), ": a live camera, which doctor does not open"),
             absl::StrCat("corbslam rig check --source '", HideSecrets(source),
                          "' looks at its frames for some seconds")}};
  }
  const absl::StatusOr<std::unique_ptr<FrameReader>> reader = OpenReader(*spec);
  if (!reader.ok()) return {SourceFailure(source, reader.status())};
  return LookInto(**reader, *spec, strict);
}

}  // namespace corbslam::services
