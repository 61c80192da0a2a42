#include "map_store/rocks/mission_lists.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <fstream>
#include <system_error>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/state/mission_uid.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Stands for a uid that nobody knows.
constexpr char kAnyUid[] = "-";

std::string PathOf(const std::string& folder, MissionList list) {
  return absl::StrCat(folder, "/", FileOfList(list));
}

std::string LineOf(const MissionIdentity& mission) {
  return absl::StrCat(mission.name, " ", mission.uid.empty() ? kAnyUid : mission.uid, "\n");
}

std::vector<MissionIdentity> ReadWholeList(const std::string& folder, MissionList list) {
  std::vector<MissionIdentity> missions;
  std::ifstream file(PathOf(folder, list));
  for (std::string line; std::getline(file, line);) {
    std::pair<std::string, std::string> entry = absl::StrSplit(line, absl::MaxSplits(' ', 1));
    const bool is_any = entry.second == kAnyUid;
    if (entry.first.empty() || (!is_any && !IsMissionUid(entry.second))) continue;
    missions.push_back({std::move(entry.first), is_any ? "" : std::move(entry.second)});
  }
  return missions;
}

}  // namespace

std::string FileOfList(MissionList list) {
  return list == MissionList::kDeleted ? "DELETED" : "PROMISED";
}

absl::Status AddToMissionList(const std::string& folder, MissionList list,
                              const MissionIdentity& mission) {
  const std::string path = PathOf(folder, list);
  const auto failed = [&path] {
    const std::error_code error(errno, std::generic_category());
    return absl::UnavailableError(absl::StrCat(path, ": ", error.message()));
  };
  const int fd = open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return failed();
  const absl::Cleanup closed = [fd] { close(fd); };
  // A line before it that was cut short must not swallow this one.
  const std::string line = absl::StrCat("\n", LineOf(mission));
  errno = 0;
  if (write(fd, line.data(), line.size()) != static_cast<ssize_t>(line.size())) return failed();
  if (fdatasync(fd) != 0) return failed();
  return SyncFolder(folder);
}

std::vector<MissionIdentity> ReadMissionList(const std::string& folder, MissionList list) {
  std::vector<MissionIdentity> missions = ReadWholeList(folder, list);
  if (missions.size() > Journal::kMaxListed) {
    missions.erase(missions.begin(), missions.end() - static_cast<ptrdiff_t>(Journal::kMaxListed));
  }
  return missions;
}

void ShortenMissionList(const std::string& folder, MissionList list) {
  if (ReadWholeList(folder, list).size() < 2 * Journal::kMaxListed) return;
  std::string lines;
  for (const MissionIdentity& mission : ReadMissionList(folder, list)) lines += LineOf(mission);
  absl::StatusOr<AtomicFile> file =
      AtomicFile::Create(PathOf(folder, list), AtomicFile::Old::kReplaced);
  if (file.ok() && file->Append(lines).ok()) file->Finish().IgnoreError();
}

}  // namespace corbslam::map_store
