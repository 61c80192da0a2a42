#include "services/programs/store_journal.h"

#include <glog/logging.h>
#include <unistd.h>

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "map_store/postgres/postgres_journal.h"
#include "services/programs/checks.h"
#include "services/programs/store_address.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::PostgresJournal;
using map_store::PostgresJournalOptions;
using map_store::RocksJournal;
using map_store::RocksJournalOptions;

namespace {

constexpr char kPostgres[] = "postgres:";

std::string NameOfThisProcess() {
  char host[256] = "";
  return gethostname(host, sizeof(host) - 1) == 0 ? absl::StrCat("process ", getpid(), " of ", host)
                                                  : absl::StrCat("process ", getpid());
}

}  // namespace

PostgresJournalOptions PostgresOptionsOf(const JournalFlags& flags) {
  PostgresJournalOptions options;
  // postgres://HOST/DATABASE is a URI by itself.
  const bool is_whole = absl::StartsWith(flags.journal, "postgres://");
  options.uri = is_whole ? flags.journal : std::string(absl::StripPrefix(flags.journal, kPostgres));
  options.password_file = flags.password_file;
  options.lease = absl::Seconds(flags.lease_s);
  options.balance.above = flags.balance_above;
  options.workers = flags.workers;
  options.holder_name = NameOfThisProcess();
  return options;
}

absl::Status CheckJournalFlags(const JournalFlags& flags) {
  RETURN_IF_ERROR(CheckAdvertise(flags.advertise, !flags.journal.empty() && flags.lease_s > 0));
  if (flags.journal.empty()) {
    if (!flags.password_file.empty()) {
      return absl::InvalidArgumentError("--journal-password-file is of no use without --journal");
    }
    return flags.data_dir.empty() ? absl::OkStatus() : CheckFolder("--data-dir", flags.data_dir);
  }
  if (!flags.data_dir.empty()) {
    return absl::InvalidArgumentError(
        "--journal and --data-dir exclude each other: a store keeps its missions in one of them");
  }
  if (flags.lease_s != 0 && flags.lease_s < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("--journal-lease is ", flags.lease_s, ", must be 0 or at least 3"));
  }
  if (!absl::StartsWith(flags.journal, kPostgres)) {
    return absl::InvalidArgumentError(
        "--journal must be postgres:URI, as postgres:postgresql://corbslam@db1:5432/corbslam");
  }
  const absl::Status read = map_store::ReadConnectionWords(PostgresOptionsOf(flags)).status();
  if (read.ok()) return read;
  return absl::Status(read.code(), absl::StrCat("--journal: ", read.message()));
}

absl::StatusOr<OpenedJournal> OpenJournal(const JournalFlags& flags, double scrub_mb_per_s) {
  // A folder is judged by who opens it, whose error says more.
  const bool is_of_folder =
      flags.journal.empty() && flags.password_file.empty() && flags.advertise.empty();
  if (!is_of_folder) RETURN_IF_ERROR(CheckJournalFlags(flags));
  OpenedJournal opened;
  if (!flags.journal.empty()) {
    ASSIGN_OR_RETURN(opened.journal, PostgresJournal::Open(PostgresOptionsOf(flags)));
    return opened;
  }
  if (flags.data_dir.empty()) {
    LOG(WARNING) << "no --data-dir, no --journal: missions are kept in memory and end with this "
                    "process";
    opened.journal = std::make_unique<InMemoryJournal>();
    return opened;
  }
  RocksJournalOptions options;
  options.directory = flags.data_dir;
  options.min_free_bytes = flags.min_free_mb << 20;
  options.scrub_bytes_per_s = static_cast<uint64_t>(scrub_mb_per_s * 1e6);
  ASSIGN_OR_RETURN(std::unique_ptr<RocksJournal> journal, RocksJournal::Open(options));
  opened.rocks = journal.get();
  opened.journal = std::move(journal);
  return opened;
}

std::string DescribeJournal(const JournalFlags& flags) {
  if (flags.journal.empty()) return flags.data_dir.empty() ? "memory alone" : flags.data_dir;
  const auto words = map_store::ReadConnectionWords(PostgresOptionsOf(flags));
  return words.ok() ? map_store::NameOfDatabase(*words) : "no database";
}

}  // namespace corbslam::services
