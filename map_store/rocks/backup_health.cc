#include "map_store/rocks/backup_health.h"

#include <fstream>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

std::string PathOfHealth(const std::string& folder) { return folder + "/VERIFIED"; }

}  // namespace

HealthByNumber ReadBackupHealth(const std::string& folder) {
  HealthByNumber health;
  std::ifstream file(PathOfHealth(folder));
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> fields = absl::StrSplit(line, absl::MaxSplits(' ', 2));
    uint32_t number = 0;
    int64_t verified_ns = 0;
    if (fields.size() != 3 || !absl::SimpleAtoi(fields[0], &number) ||
        !absl::SimpleAtoi(fields[1], &verified_ns)) {
      continue;
    }
    health[number] = {verified_ns == 0 ? absl::InfinitePast() : absl::FromUnixNanos(verified_ns),
                      fields[2]};
  }
  return health;
}

absl::Status WriteBackupHealth(const std::string& folder, const HealthByNumber& health) {
  std::string lines;
  for (const auto& [number, of] : health) {
    const int64_t verified_ns =
        of.verified == absl::InfinitePast() ? 0 : absl::ToUnixNanos(of.verified);
    absl::StrAppend(&lines, number, " ", verified_ns, " ",
                    absl::StrReplaceAll(of.damage, {{"\n", " "}}), "\n");
  }
  ASSIGN_OR_RETURN(AtomicFile file,
                   AtomicFile::Create(PathOfHealth(folder), AtomicFile::Old::kReplaced));
  RETURN_IF_ERROR(file.Append(lines));
  // It can be found out again.
  return file.FinishUnsynced();
}

}  // namespace corbslam::map_store
