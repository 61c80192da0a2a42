// Lends a bounded number of connections to one database, and finds its primary again when it has
// moved.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_SQL_POOL_H_
#define CORBSLAM_MAP_STORE_POSTGRES_SQL_POOL_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/postgres/postgres_options.h"
#include "map_store/postgres/sql_connection.h"

namespace corbslam::map_store {

// Thread-safe. All errors begin with "journal postgres HOST/DATABASE: ".
class SqlPool {
 public:
  // A connection that goes back when this does. A transaction that is open then is rolled back.
  class Lease {
   public:
    Lease(SqlPool* pool, std::unique_ptr<SqlConnection> connection)
        : pool_(pool), connection_(std::move(connection)) {}
    Lease(Lease&&) = default;
    Lease& operator=(Lease&&) = delete;
    ~Lease();
    SqlConnection* operator->() const { return connection_.get(); }

   private:
    SqlPool* pool_;
    std::unique_ptr<SqlConnection> connection_;
  };

  // INVALID_ARGUMENT: the URI.
  static absl::StatusOr<std::unique_ptr<SqlPool>> Make(const PostgresJournalOptions& options);

  // Lends a connection, perhaps a new one. UNAVAILABLE: all are lent, for too long, or there is no
  // server that writes.
  absl::StatusOr<Lease> Borrow() ABSL_LOCKS_EXCLUDED(mutex_);
  // Reads: runs the statements, as one, and once more if the connection breaks.
  absl::StatusOr<std::vector<SqlResult>> Read(const SqlStatements& statements);
  // Writes: commits the statements as one transaction. They do no more when they are run again,
  // which happens until it is known that they are done, or known that they are not.
  absl::StatusOr<std::vector<SqlResult>> WriteAgain(const SqlStatements& statements);
  // Calls `once` with a connection until it returns something else than a broken connection, a
  // conflict, or an unknown outcome; a few times at most. Returns its last outcome.
  SqlOutcome Try(const std::function<SqlOutcome(SqlConnection& connection)>& once);

  // Returns OK if a server takes writes now. One that only reads is left, so that the next
  // connection looks for the one that writes.
  absl::Status CheckWrites();

  // Returns how often no connection was free for too long.
  uint64_t times_busy() const { return times_busy_; }
  // Adds the journal's name to an error.
  absl::Status Name(const absl::Status& error) const;
  const std::string& name() const { return name_; }
  const std::string& warning() const { return warning_; }

 private:
  SqlPool(const PostgresJournalOptions& options, ConnectionWords words);

  absl::StatusOr<std::unique_ptr<SqlConnection>> Connect() const;
  void GiveBack(std::unique_ptr<SqlConnection> connection) ABSL_LOCKS_EXCLUDED(mutex_);

  const PostgresJournalOptions options_;
  const ConnectionWords words_;
  const std::string name_;
  const std::string warning_;
  std::atomic<uint64_t> times_busy_ = 0;

  absl::Mutex mutex_;
  std::vector<std::unique_ptr<SqlConnection>> idle_ ABSL_GUARDED_BY(mutex_);
  size_t lent_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_SQL_POOL_H_
