#include "map_store/postgres/sql_pool.h"

#include <fstream>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr int kTries = 3;
constexpr absl::Duration kBetweenTries = absl::Milliseconds(100);

absl::StatusOr<std::string> ReadPassword(const std::string& path) {
  if (path.empty()) return std::string();
  std::ifstream file(path);
  std::string password;
  if (!std::getline(file, password)) {
    return absl::UnavailableError(absl::StrCat("the password file ", path, " can't be read"));
  }
  return std::string(absl::StripAsciiWhitespace(password));
}

}  // namespace

SqlPool::Lease::~Lease() {
  if (connection_ != nullptr) pool_->GiveBack(std::move(connection_));
}

SqlPool::SqlPool(const PostgresJournalOptions& options, ConnectionWords words)
    : options_(options),
      words_(std::move(words)),
      name_(absl::StrCat("journal ", NameOfDatabase(words_))),
      warning_(WarnOfConnection(words_)) {}

absl::StatusOr<std::unique_ptr<SqlPool>> SqlPool::Make(const PostgresJournalOptions& options) {
  ASSIGN_OR_RETURN(ConnectionWords words, ReadConnectionWords(options));
  return std::unique_ptr<SqlPool>(new SqlPool(options, std::move(words)));
}

absl::Status SqlPool::Name(const absl::Status& error) const {
  if (error.ok()) return error;
  // A conflict that does not end is the server's trouble for those who wait.
  const absl::StatusCode code =
      absl::IsAborted(error) ? absl::StatusCode::kUnavailable : error.code();
  const std::string message = absl::StrCat(name_, ": ", error.message());
  return code == error.code() ? WithMessage(error, message) : absl::Status(code, message);
}

absl::StatusOr<std::unique_ptr<SqlConnection>> SqlPool::Connect() const {
  ASSIGN_OR_RETURN(const std::string password, ReadPassword(options_.password_file));
  return SqlConnection::Connect(words_, password, options_);
}

absl::StatusOr<SqlPool::Lease> SqlPool::Borrow() {
  const absl::Time until = absl::Now() + options_.pool_timeout;
  {
    absl::MutexLock lock(&mutex_);
    const auto is_free = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return lent_ < options_.connections;
    };
    if (!mutex_.AwaitWithDeadline(absl::Condition(&is_free), until)) {
      ++times_busy_;
      return absl::UnavailableError(absl::StrCat(name_, ": all ", options_.connections,
                                                 " connections were busy for ",
                                                 absl::FormatDuration(options_.pool_timeout)));
    }
    ++lent_;
    while (!idle_.empty()) {
      std::unique_ptr<SqlConnection> connection = std::move(idle_.back());
      idle_.pop_back();
      if (connection->IsStillThere()) return Lease(this, std::move(connection));
    }
  }
  absl::StatusOr<std::unique_ptr<SqlConnection>> connected = Connect();
  if (connected.ok()) return Lease(this, *std::move(connected));
  GiveBack(nullptr);
  return Name(connected.status());
}

void SqlPool::GiveBack(std::unique_ptr<SqlConnection> connection) {
  const bool is_good = connection != nullptr && !connection->is_broken();
  absl::MutexLock lock(&mutex_);
  --lent_;
  if (is_good) {
    idle_.push_back(std::move(connection));
  } else if (connection != nullptr) {
    // The others are connected to the same server.
    idle_.clear();
  }
}

SqlOutcome SqlPool::Try(const std::function<SqlOutcome(SqlConnection& connection)>& once) {
  SqlOutcome outcome;
  for (int i = 0; i < kTries; ++i) {
    if (i > 0) absl::SleepFor(i * kBetweenTries);
    absl::StatusOr<Lease> lease = Borrow();
    // What an earlier attempt left unknown stays so.
    if (!lease.ok()) return {lease.status(), outcome.is_unknown};
    const bool was_unknown = outcome.is_unknown;
    outcome = once(*lease->operator->());
    if (outcome.status.ok()) return outcome;
    const bool again = outcome.is_unknown || (*lease)->is_broken() || IsAborted(outcome.status);
    outcome.is_unknown |= was_unknown && again;
    if (!again) break;
  }
  outcome.status = Name(outcome.status);
  return outcome;
}

absl::StatusOr<std::vector<SqlResult>> SqlPool::Read(const SqlStatements& statements) {
  std::vector<SqlResult> results;
  const SqlOutcome outcome = Try([&](SqlConnection& connection) -> SqlOutcome {
    absl::StatusOr<std::vector<SqlResult>> read = connection.Run(statements);
    if (!read.ok()) return {read.status()};
    results = *std::move(read);
    return {absl::OkStatus()};
  });
  RETURN_IF_ERROR(outcome.status);
  return results;
}

absl::Status SqlPool::CheckWrites() {
  ASSIGN_OR_RETURN(const std::vector<SqlResult> read, Read({{"SHOW transaction_read_only"}}));
  if (read.front().Bytes(0, 0) != "on") return absl::OkStatus();
  {
    absl::MutexLock lock(&mutex_);
    idle_.clear();
  }
  return absl::UnavailableError(absl::StrCat(name_, ": the server only reads"));
}

absl::StatusOr<std::vector<SqlResult>> SqlPool::WriteAgain(const SqlStatements& statements) {
  std::vector<SqlResult> results;
  SqlStatements all = {{"BEGIN"}};
  all.insert(all.end(), statements.begin(), statements.end());
  const SqlOutcome outcome = Try([&](SqlConnection& connection) -> SqlOutcome {
    absl::StatusOr<std::vector<SqlResult>> written = connection.Run(all);
    if (!written.ok()) {
      connection.Rollback();
      return {written.status()};
    }
    results = *std::move(written);
    return connection.Commit({});
  });
  RETURN_IF_ERROR(outcome.status);
  results.erase(results.begin());
  return results;
}

}  // namespace corbslam::map_store
