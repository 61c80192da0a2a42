#include "map_store/postgres/sql_connection.h"

#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

std::string OneLine(const char* text) {
  std::string line(absl::StripTrailingAsciiWhitespace(text == nullptr ? "" : text));
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

std::string FieldOf(const PGresult* result, int field) {
  const char* text = PQresultErrorField(result, field);
  return text == nullptr ? "" : text;
}

// PostgreSQL's appendix "Error Codes" has these.
absl::StatusCode CodeOf(std::string_view sqlstate) {
  const std::string_view kind = sqlstate.substr(0, 2);
  if (sqlstate == "40003")
    return absl::StatusCode::kUnavailable;  // Nobody knows what became of it.
  if (kind == "40") return absl::StatusCode::kAborted;
  if (kind == "53" && sqlstate != "53300") return absl::StatusCode::kResourceExhausted;
  if (sqlstate == "23505") return absl::StatusCode::kAlreadyExists;
  if (sqlstate == "XX001" || sqlstate == "XX002") return absl::StatusCode::kDataLoss;
  if (kind == "42" || kind == "3F" || kind == "3D" || kind == "28") {
    return absl::StatusCode::kFailedPrecondition;
  }
  return absl::StatusCode::kUnavailable;
}

// Says what a session is allowed to take.
SqlStatements SessionLimits(const PostgresJournalOptions& options) {
  const auto text = [](absl::Duration limit) {
    return SqlValue::Text(absl::StrCat(absl::ToInt64Milliseconds(limit)));
  };
  // A store that is stopped amid a transaction keeps others from its mission for so long.
  absl::Duration idle = 2 * options.statement_timeout;
  if (options.lease > absl::ZeroDuration()) idle = std::min(idle, options.lease / 2);
  return {{"SELECT set_config('statement_timeout', $1, false)", {text(options.statement_timeout)}},
          {"SELECT set_config('lock_timeout', $1, false)", {text(options.lock_timeout)}},
          {"SELECT set_config('idle_in_transaction_session_timeout', $1, false)", {text(idle)}}};
}

}  // namespace

SqlConnection::SqlConnection(pg_conn* connection, absl::Duration patience)
    : connection_(connection), patience_(patience) {}

SqlConnection::~SqlConnection() { PQfinish(connection_); }

void SqlConnection::OnNotice(void* self, const pg_result* notice) {
  if (FieldOf(notice, PG_DIAG_SEVERITY_NONLOCALIZED) == "WARNING") {
    static_cast<SqlConnection*>(self)->warned_ = true;
  }
}

absl::StatusOr<std::unique_ptr<SqlConnection>> SqlConnection::Connect(
    const ConnectionWords& words, const std::string& password,
    const PostgresJournalOptions& options) {
  std::vector<const char*> keys;
  std::vector<const char*> values;
  for (const auto& [key, value] : words) {
    keys.push_back(key.c_str());
    values.push_back(value.c_str());
  }
  if (!password.empty()) {
    keys.push_back("password");
    values.push_back(password.c_str());
  }
  keys.push_back(nullptr);
  values.push_back(nullptr);
  std::unique_ptr<SqlConnection> made(new SqlConnection(
      PQconnectdbParams(keys.data(), values.data(), 0), 2 * options.statement_timeout));
  PGconn* connection = made->connection_;
  if (PQstatus(connection) != CONNECTION_OK) {
    return absl::UnavailableError(OneLine(PQerrorMessage(connection)));
  }
  PQsetNoticeReceiver(connection, &SqlConnection::OnNotice, made.get());
  if (PQsetnonblocking(connection, 1) != 0 || PQenterPipelineMode(connection) != 1) {
    return absl::UnavailableError(OneLine(PQerrorMessage(connection)));
  }
  RETURN_IF_ERROR(made->Run(SessionLimits(options)).status());
  return made;
}

absl::Status SqlConnection::Lost(const std::string& why) {
  is_broken_ = true;
  return absl::UnavailableError(why);
}

absl::Status SqlConnection::ToError(const pg_result* result) {
  const std::string sqlstate = FieldOf(result, PG_DIAG_SQLSTATE);
  // A server that only reads, or is about to go, is not the primary any more.
  if (sqlstate == "25006" || absl::StartsWith(sqlstate, "57P")) is_broken_ = true;
  if (sqlstate.empty()) return absl::UnavailableError(OneLine(PQresultErrorMessage(result)));
  const std::string detail = FieldOf(result, PG_DIAG_MESSAGE_DETAIL);
  return absl::Status(CodeOf(sqlstate), absl::StrCat(FieldOf(result, PG_DIAG_MESSAGE_PRIMARY),
                                                     detail.empty() ? "" : ": ", detail,
                                                     " (SQLSTATE ", sqlstate, ")"));
}

bool SqlConnection::AwaitSocket(bool writes, absl::Time until) {
  pollfd ready = {.fd = PQsocket(connection_),
                  .events = static_cast<short>(writes ? POLLIN | POLLOUT : POLLIN),
                  .revents = 0};
  const int64_t left_ms = std::max<int64_t>(0, absl::ToInt64Milliseconds(until - absl::Now()));
  return poll(&ready, 1, static_cast<int>(std::min<int64_t>(left_ms, 1 << 30))) > 0;
}

bool SqlConnection::IsStillThere() {
  if (is_broken_ || PQstatus(connection_) != CONNECTION_OK) return false;
  if (!AwaitSocket(false, absl::Now())) return true;
  // Nobody asked for anything: what comes now is the end.
  return PQconsumeInput(connection_) == 1 && PQstatus(connection_) == CONNECTION_OK &&
         !AwaitSocket(false, absl::Now());
}

bool SqlConnection::Send(const SqlStatements& statements) {
  for (const SqlStatement& statement : statements) {
    std::vector<Oid> types;
    std::vector<const char*> values;
    std::vector<int> sizes;
    for (const SqlValue& value : statement.values) {
      types.push_back(value.type());
      values.push_back(value.data());
      sizes.push_back(value.size());
    }
    const std::vector<int> binary(values.size(), 1);
    if (PQsendQueryParams(connection_, statement.text, static_cast<int>(values.size()),
                          types.data(), values.data(), sizes.data(), binary.data(), 1) != 1) {
      return false;
    }
  }
  return PQpipelineSync(connection_) == 1;
}

bool SqlConnection::Receive(absl::Time until, pg_result** result) {
  while (true) {
    const int unsent = PQflush(connection_);
    if (unsent < 0) return false;
    if (unsent == 0 && PQisBusy(connection_) == 0) break;
    if (!AwaitSocket(unsent > 0, until) || PQconsumeInput(connection_) != 1) return false;
  }
  *result = PQgetResult(connection_);
  return true;
}

SqlConnection::Answers SqlConnection::Exchange(const SqlStatements& statements) {
  Answers answers;
  const absl::Time until = absl::Now() + patience_;
  const auto lose = [&] {
    answers.lost = true;
    const std::string said = OneLine(PQerrorMessage(connection_));
    answers.error = Lost(said.empty() ? "the server is silent" : said);
    return answers;
  };
  if (is_broken_ || !Send(statements)) return lose();
  size_t ended = 0;
  while (true) {
    pg_result* result = nullptr;
    if (!Receive(until, &result)) return lose();
    if (result == nullptr) {
      if (PQstatus(connection_) != CONNECTION_OK || ++ended > 2 * statements.size() + 2) {
        return lose();
      }
      continue;
    }
    const SqlResult held(result);
    const ExecStatusType status = PQresultStatus(result);
    if (status == PGRES_PIPELINE_SYNC) return answers;
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) {
      answers.results.push_back(held);
    } else if (status != PGRES_PIPELINE_ABORTED && answers.error.ok()) {
      answers.error = ToError(result);
      answers.last_failed = answers.results.size() + 1 == statements.size();
      if (PQstatus(connection_) != CONNECTION_OK) return lose();
    }
  }
}

absl::StatusOr<std::vector<SqlResult>> SqlConnection::Run(const SqlStatements& statements) {
  Answers answers = Exchange(statements);
  if (!answers.error.ok()) return answers.error;
  return std::move(answers.results);
}

SqlOutcome SqlConnection::Commit(SqlStatements statements) {
  statements.push_back({"COMMIT"});
  warned_ = false;
  const Answers answers = Exchange(statements);
  if (answers.lost) return {answers.error, true};
  if (!answers.error.ok()) {
    // What failed before the commit is not done; of a commit that failed only a conflict is known.
    const bool is_known = !answers.last_failed || absl::IsAborted(answers.error);
    if (!answers.last_failed) Rollback();
    return {answers.error, !is_known};
  }
  if (answers.results.back().command() != "COMMIT") {
    return {absl::AbortedError("the transaction had failed already")};
  }
  if (!warned_) return {absl::OkStatus()};
  return {absl::UnavailableError("the server warned while it committed: a standby may lack it"),
          true};
}

void SqlConnection::Rollback() {
  if (!is_broken_) Run({{"ROLLBACK"}}).status().IgnoreError();
}

}  // namespace corbslam::map_store
