// One connection to a server that speaks PostgreSQL's protocol. Statements travel in pipelines: all
// are sent before the first answer is awaited.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_SQL_CONNECTION_H_
#define CORBSLAM_MAP_STORE_POSTGRES_SQL_CONNECTION_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "map_store/postgres/postgres_options.h"
#include "map_store/postgres/sql_values.h"

struct pg_conn;
struct pg_result;

namespace corbslam::map_store {

// What became of a transaction.
struct SqlOutcome {
  // OK: it is done and lasts. ABORTED: it is not, because another one was in its way; it may be
  // tried again.
  absl::Status status;
  // With an error: nobody knows whether it is done. The answer is lost, or the wait for a standby
  // was cancelled.
  bool is_unknown = false;
};

// Not thread-safe. Errors are UNAVAILABLE (connection, server, time limits), RESOURCE_EXHAUSTED (no
// room), FAILED_PRECONDITION (no such table, no right), DATA_LOSS (the server says that its files
// are damaged) and ABORTED (as above), each with what the server said.
class SqlConnection {
 public:
  // `password` may be empty.
  static absl::StatusOr<std::unique_ptr<SqlConnection>> Connect(
      const ConnectionWords& words, const std::string& password,
      const PostgresJournalOptions& options);
  ~SqlConnection();

  // Returns the statements' results in their order, or the first error; the rest was not run then.
  // Without a transaction they are one together.
  absl::StatusOr<std::vector<SqlResult>> Run(const SqlStatements& statements);
  // Runs the statements in the transaction that is open, and commits it.
  SqlOutcome Commit(SqlStatements statements);
  // Gives up the transaction that is open.
  void Rollback();

  // Whether the connection is of no use any more.
  bool is_broken() const { return is_broken_; }
  // Looks without waiting whether the server has closed the connection, or said goodbye.
  bool IsStillThere();

 private:
  struct Answers {
    std::vector<SqlResult> results;
    absl::Status error;        // Of the first statement that failed.
    bool last_failed = false;  // The error is the last statement's own.
    bool lost = false;         // The connection broke before all answers were there.
  };

  SqlConnection(pg_conn* connection, absl::Duration patience);
  static void OnNotice(void* self, const pg_result* notice);

  Answers Exchange(const SqlStatements& statements);
  bool Send(const SqlStatements& statements);
  // Waits for the next result of the pipeline; null between two statements' results. False: the
  // connection is lost, or the server silent for too long.
  bool Receive(absl::Time until, pg_result** result);
  // Returns false when nothing can be read or written until then.
  bool AwaitSocket(bool writes, absl::Time until);
  absl::Status Lost(const std::string& why);
  absl::Status ToError(const pg_result* result);

  pg_conn* const connection_;
  const absl::Duration patience_;
  bool is_broken_ = false;
  bool warned_ = false;  // The server warned since this was last set to false.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_SQL_CONNECTION_H_
