// Implements `corbslam journal copy`: missions go from a folder to a database, or back.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "map_store/fleet/directory.h"
#include "map_store/postgres/fleet_directory.h"
#include "map_store/postgres/sql_pool.h"
#include "map_store/store/journal_copy.h"
#include "services/programs/store_journal.h"
#include "services/tool/commands/journal_actions.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::CopiedMission;

namespace {

struct CopyArguments {
  std::string from;
  std::string to;
  std::string password_file;
};

// A folder, or postgres:URI.
JournalFlags FlagsOf(const std::string& place, const CopyArguments& arguments) {
  JournalFlags flags;
  if (absl::StartsWith(place, "postgres:")) {
    flags.journal = place;
    flags.password_file = arguments.password_file;
  } else {
    flags.data_dir = place;
  }
  return flags;
}

// A store that runs goes on writing what the copy would lack.
absl::Status CheckNobodyRuns(const JournalFlags& flags) {
  if (flags.journal.empty()) return absl::OkStatus();  // A folder is locked.
  RETURN_IF_ERROR(CheckJournalFlags(flags));
  ASSIGN_OR_RETURN(const std::unique_ptr<map_store::SqlPool> pool,
                   map_store::SqlPool::Make(PostgresOptionsOf(flags)));
  ASSIGN_OR_RETURN(const auto stores, map_store::FleetDirectory(pool.get()).ListStores());
  for (const map_store::DirectoryStore& store : stores) {
    if (!store.IsAlive()) continue;
    return absl::FailedPreconditionError(
        absl::StrCat(pool->name(), ": store ", store.name, " runs: stop all stores first"));
  }
  return absl::OkStatus();
}

absl::StatusOr<OpenedJournal> OpenStopped(const JournalFlags& flags) {
  RETURN_IF_ERROR(CheckNobodyRuns(flags));
  return OpenJournal(flags, /*scrub_mb_per_s=*/0);
}

nlohmann::ordered_json CopyToJson(const CopiedMission& mission) {
  nlohmann::ordered_json json = {{"mission", mission.name},
                                 {"agents", mission.agents},
                                 {"local_maps", mission.local_maps},
                                 {"keyframes", mission.keyframes},
                                 {"pictures", mission.pictures},
                                 {"was_there", mission.was_there},
                                 {"error", nullptr}};
  if (!mission.status.ok()) json["error"] = std::string(mission.status.message());
  return json;
}

std::string Describe(const CopiedMission& mission) {
  if (!mission.status.ok()) {
    return absl::StrCat(mission.name, ": NOT COPIED: ", mission.status.message(), "\n");
  }
  return absl::StrCat(mission.name,
                      mission.was_there ? ": was there: " : ": copied: ", mission.agents,
                      " agents, ", mission.local_maps, " local maps, ", mission.keyframes,
                      " keyframes, ", mission.pictures, " pictures; the copy is the same\n");
}

absl::Status Copy(const CopyArguments& arguments) {
  ASSIGN_OR_RETURN(const OpenedJournal from, OpenStopped(FlagsOf(arguments.from, arguments)));
  ASSIGN_OR_RETURN(const OpenedJournal to, OpenStopped(FlagsOf(arguments.to, arguments)));
  size_t failed = 0;
  size_t all = 0;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  RETURN_IF_ERROR(
      map_store::CopyJournal(*from.journal, *to.journal, [&](const CopiedMission& mission) {
        Say(Describe(mission));
        rows.push_back(CopyToJson(mission));
        ++all;
        failed += mission.status.ok() ? 0 : 1;
      }));
  PrintResult("", rows);
  if (failed == 0) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(failed, " of ", all, " missions of ", arguments.from,
                                          " are not in ", arguments.to));
}

}  // namespace

void AddJournalCopy(CLI::App& journal, Command& chosen) {
  auto arguments = std::make_shared<CopyArguments>();
  CLI::App* copy = journal.add_subcommand(
      "copy",
      "Copy all missions from a folder to a database, or back, and compare each with its copy; "
      "stores of both must be stopped");
  copy->add_option("--from", arguments->from, "Folder of a store, or postgres:URI")->required();
  copy->add_option("--to", arguments->to, "Likewise; what is there already stays")->required();
  copy->add_option("--journal-password-file", arguments->password_file,
                   "File with the database's password alone");
  copy->callback([arguments, &chosen] { chosen = [arguments] { return Copy(*arguments); }; });
}

}  // namespace corbslam::services
