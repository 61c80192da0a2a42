// The options of a journal on PostgreSQL, and what its URI may say.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_OPTIONS_H_
#define CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_OPTIONS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "map_store/fleet/balance.h"

namespace corbslam::map_store {

struct PostgresJournalOptions {
  // As libpq takes it, a URI or keywords with values; without a password, which would show in the
  // list of processes.
  std::string uri;
  // A file with the password alone, read again for each connection; empty: libpq's own ways.
  std::string password_file = {};
  // As RocksJournalOptions has it.
  uint64_t min_bytes_between_snapshots = 32 << 20;
  // At most so many connections are open; whoever needs one more waits for `pool_timeout`.
  size_t connections = 8;
  absl::Duration pool_timeout = absl::Seconds(10);
  absl::Duration connect_timeout = absl::Seconds(5);
  // The server ends a statement, or a wait for a lock, that takes longer. A server that says
  // nothing for twice the first is given up.
  absl::Duration statement_timeout = absl::Seconds(30);
  absl::Duration lock_timeout = absl::Seconds(10);
  // What was appended and nobody waits for is written after so long.
  absl::Duration flush_after = absl::Seconds(1);
  // This process holds the missions that it uses, and others may take one over once it has not said
  // for so long that it lives; zero: at once.
  absl::Duration lease = absl::ZeroDuration();
  // With a lease: when missions go from this store to others that have less to do.
  BalanceRules balance = {};
  // With a lease: HOST:PORT of the fusion workers that this store offers to the others.
  std::vector<std::string> workers = {};
  // The process, for people.
  std::string holder_name = "a map store";
};

// Keywords of a connection, as PQconnectdbParams takes them.
using ConnectionWords = std::map<std::string, std::string>;

// Returns the URI's keywords, with these added where it does not say them: sslmode=verify-full for
// hosts that are reached over a network, target_session_attrs=read-write, a time limit for
// connecting, keepalives. INVALID_ARGUMENT: libpq can't read it, or it has a password.
absl::StatusOr<ConnectionWords> ReadConnectionWords(const PostgresJournalOptions& options);
// Returns the server and the database, for people: "postgres db1:5432/corbslam".
std::string NameOfDatabase(const ConnectionWords& words);
// Returns what is to be known of a connection that is not encrypted or not verified; empty: it is
// both, or needs neither.
std::string WarnOfConnection(const ConnectionWords& words);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_OPTIONS_H_
