#include "services/programs/checks.h"

#include <unistd.h>

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "services/http/web_server.h"
#include "services/runtime/address.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::services {

namespace fs = std::filesystem;

namespace {

absl::Status OfFlag(absl::string_view flag, const absl::Status& status) {
  return status.ok() ? status
                     : absl::InvalidArgumentError(absl::StrCat(flag, ": ", status.message()));
}

}  // namespace

absl::Status CheckFlagAddress(absl::string_view flag, const std::string& address) {
  return OfFlag(flag, ParseListenAddress(address).status());
}

absl::Status CheckFlagServer(absl::string_view flag, const std::string& address) {
  return OfFlag(flag, ParseServerAddress(address).status());
}

absl::Status CheckFolder(absl::string_view flag, const std::string& path) {
  std::error_code error;
  const fs::path there = NearestThere(path);
  if (!fs::is_directory(there, error)) {
    return absl::InvalidArgumentError(
        absl::StrCat(flag, " ", path, ": ", there.string(), " is no folder"));
  }
  if (access(there.c_str(), W_OK | X_OK) != 0) {
    return absl::PermissionDeniedError(
        absl::StrCat(flag, " ", path, ": can't write to ", there.string()));
  }
  return absl::OkStatus();
}

absl::Status CheckFolderOf(const std::string& file) {
  std::error_code error;
  const fs::path folder = fs::absolute(file, error).parent_path();
  if (fs::is_directory(folder, error) && access(folder.c_str(), W_OK | X_OK) == 0) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat("can't write ", file, ": there is no folder ",
                                                 folder.string(), " that can be written to"));
}

std::vector<absl::Status> CheckObserving(const ObserveFlags& flags) {
  std::vector<absl::Status> found;
  if (!flags.metrics_listen.empty()) {
    found.push_back(OfFlag("--metrics-listen", CheckHttpAddress(flags.metrics_listen)));
  }
  return found;
}

absl::Status CheckVocabulary(const std::string& path) {
  ASSIGN_OR_RETURN(const auto vocabulary, Vocabulary::Load(path));
  return vocabulary->Verify();
}

}  // namespace corbslam::services
