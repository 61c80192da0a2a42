#include "map_store/rocks/journal_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;

absl::Status Failed(absl::string_view path, absl::string_view what, const std::error_code& error) {
  const std::string message = absl::StrCat(path, ": ", what, ": ", error.message());
  if (error == std::errc::no_space_on_device) return absl::ResourceExhaustedError(message);
  return absl::UnavailableError(message);
}

// Returns the path without links and dots, as far as it is there.
std::string ResolvePath(const std::string& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(path, error);
  std::string text = (error ? fs::absolute(path, error) : found).string();
  while (text.size() > 1 && text.back() == '/') text.pop_back();
  return text;
}

std::error_code LastError() { return {errno, std::generic_category()}; }

}  // namespace

absl::Status SyncFolder(const std::string& path) {
  const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return Failed(path, "can't be opened", LastError());
  const bool synced = fsync(folder) == 0;
  const std::error_code error = LastError();
  close(folder);
  return synced ? absl::OkStatus() : Failed(path, "can't be synced", error);
}

bool IsWithin(const std::string& outer, const std::string& inner) {
  const std::string from = ResolvePath(outer);
  const std::string path = ResolvePath(inner);
  return path == from || absl::StartsWith(path, from == "/" ? from : from + "/");
}

uint64_t BytesIn(const std::string& path) {
  uint64_t bytes = 0;
  std::error_code error;
  // Files come and go meanwhile.
  for (fs::recursive_directory_iterator it(path, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code gone;
    const uint64_t size = it->is_regular_file(gone) && !gone ? it->file_size(gone) : 0;
    if (!gone) bytes += size;
  }
  return bytes;
}

JournalFolder::JournalFolder(const std::string& directory)
    : path_(absl::StrCat(directory, "/missions")) {}

bool JournalFolder::exists() const {
  std::error_code error;
  return fs::is_directory(path_, error);
}

absl::Status JournalFolder::Make() const {
  std::error_code error;
  fs::create_directories(path_, error);
  if (error) return Failed(path_, "can't be made", error);
  return SyncFolder(fs::path(path_).parent_path().string());
}

std::string JournalFolder::PathOf(absl::string_view mission, absl::string_view use) const {
  return absl::StrCat(path_, "/", mission, use);
}

absl::StatusOr<std::vector<std::string>> JournalFolder::ListInUse() const {
  std::vector<std::string> missions;
  std::error_code error;
  for (fs::directory_iterator it(path_, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    absl::string_view mission = name;
    if (absl::ConsumeSuffix(&mission, kInUse)) missions.emplace_back(mission);
  }
  if (error) return Failed(path_, "can't be read", error);
  std::sort(missions.begin(), missions.end());
  return missions;
}

absl::Status JournalFolder::Turn(absl::string_view mission, absl::string_view from,
                                 absl::string_view to) const {
  std::error_code error;
  fs::rename(PathOf(mission, from), PathOf(mission, to), error);
  if (error) return Failed(PathOf(mission, from), absl::StrCat("can't become ", to), error);
  return SyncFolder(path_);
}

absl::Status JournalFolder::Remove(absl::string_view mission, absl::string_view use) const {
  std::error_code error;
  fs::remove_all(PathOf(mission, use), error);
  return error ? Failed(PathOf(mission, use), "can't be removed", error) : absl::OkStatus();
}

absl::Status JournalFolder::RemoveLeftovers() const {
  std::error_code error;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator it(path_, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (absl::EndsWith(name, kDeleted) || absl::EndsWith(name, kBeingMade)) {
      leftovers.push_back(it->path());
    }
  }
  for (const fs::path& leftover : leftovers) {
    fs::remove_all(leftover, error);
    if (error) return Failed(leftover.string(), "can't be removed", error);
  }
  return error ? Failed(path_, "can't be read", error) : absl::OkStatus();
}

}  // namespace corbslam::map_store
