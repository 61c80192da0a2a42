// Opens the journal that a map store's flags ask for.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_JOURNAL_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_JOURNAL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/postgres/postgres_options.h"
#include "map_store/records/journal.h"
#include "map_store/rocks/rocks_journal.h"

namespace corbslam::services {

struct JournalFlags {
  std::string data_dir = {};  // Empty: no journal on a disk of this machine.
  std::string journal = {};   // postgres:URI; empty: none in a database.
  std::string password_file = {};
  double lease_s = 0;  // 0: this store has all missions of a database.
  // Share of its processors or memory beyond which a store gives missions away; 0: never.
  double balance_above = map_store::BalanceRules().above;
  std::vector<std::string> workers = {};  // HOST:PORT of those that others may use.
  std::string advertise = {};  // HOST:PORT where other stores send robots; empty: as it serves.
  uint64_t min_free_mb = map_store::RocksJournalOptions().min_free_bytes >> 20;

  // Returns whether several stores share the database's missions.
  bool is_shared() const { return !journal.empty() && lease_s > 0; }
};

// Returns what the flags say of a database; they are checked (CheckJournalFlags).
map_store::PostgresJournalOptions PostgresOptionsOf(const JournalFlags& flags);

struct OpenedJournal {
  std::unique_ptr<map_store::Journal> journal;
  map_store::RocksJournal* rocks = nullptr;  // The journal, if it is one on a disk.
};

// Returns INVALID_ARGUMENT, naming the flag and what is wanted. Connects to nothing.
absl::Status CheckJournalFlags(const JournalFlags& flags);
absl::StatusOr<OpenedJournal> OpenJournal(const JournalFlags& flags, double scrub_mb_per_s);
// Returns where missions are, for people; without secrets.
std::string DescribeJournal(const JournalFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_JOURNAL_H_
