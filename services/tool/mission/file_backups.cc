#include "services/tool/mission/file_backups.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;

constexpr char kTimeFormat[] = "%E4Y%m%dT%H%M%SZ";
constexpr char kEnding[] = ".backup";

// Returns whether a file's name is one that BackUpAll gives.
bool IsOwnName(const fs::path& path) {
  absl::Time time;
  std::string error;
  return path.extension() == kEnding &&
         absl::ParseTime(kTimeFormat, path.stem().string(), &time, &error) &&
         absl::FormatTime(kTimeFormat, time, absl::UTCTimeZone()) == path.stem().string();
}

absl::Status RemoveOld(const fs::path& folder, size_t keep) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (IsOwnName(it->path())) files.push_back(it->path());
  }
  // Names sort as times do.
  std::sort(files.rbegin(), files.rend());
  for (size_t i = std::max<size_t>(keep, 1); !error && i < files.size(); ++i) {
    fs::remove(files[i], error);
  }
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat(folder.string(), ": old backups can't be removed: ", error.message()));
}

absl::StatusOr<std::string> BackUpOne(MissionAdmin& admin, const std::string& mission,
                                      const FileBackupOptions& options, absl::Time now) {
  RETURN_IF_ERROR(CheckNameSegment("mission", mission));
  const fs::path folder = fs::path(options.folder) / mission;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return absl::UnavailableError(absl::StrCat(folder.string(), ": ", error.message()));
  }
  const std::string name =
      absl::StrCat(absl::FormatTime(kTimeFormat, now, absl::UTCTimeZone()), kEnding);
  const std::string file = (folder / name).string();
  RETURN_IF_ERROR(admin.BackUp(mission, file).status());
  RETURN_IF_ERROR(RemoveOld(folder, options.keep));
  return file;
}

}  // namespace

absl::Status BackUpAll(MissionAdmin& admin, const FileBackupOptions& options, absl::Time now,
                       const std::function<void(const std::string& mission,
                                                const absl::StatusOr<std::string>& file)>& tell) {
  ASSIGN_OR_RETURN(const std::vector<v1::Mission> missions, admin.List());
  absl::Status first;
  int failed = 0;
  for (const v1::Mission& mission : missions) {
    const std::string name = LastSegment(mission.name());
    const absl::StatusOr<std::string> file = BackUpOne(admin, name, options, now);
    tell(name, file);
    // It was deleted since it was listed.
    if (file.ok() || absl::IsNotFound(file.status())) continue;
    first.Update(file.status());
    ++failed;
  }
  if (failed == 0) return absl::OkStatus();
  return absl::Status(first.code(),
                      absl::StrCat(failed, " of ", missions.size(),
                                   " missions have no new backup; the first: ", first.message()));
}

}  // namespace corbslam::services
