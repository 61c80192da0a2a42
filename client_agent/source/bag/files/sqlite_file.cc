#include "client_agent/source/bag/files/sqlite_file.h"

#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/source/bag/files/bag_bytes.h"
#include "client_agent/source/bag/files/bag_notes.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using Database = std::unique_ptr<sqlite3, int (*)(sqlite3*)>;
using Statement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;
using Blob = std::unique_ptr<sqlite3_blob, int (*)(sqlite3_blob*)>;

absl::Status SqliteError(const std::string& path, sqlite3* database, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(
      path, ": ", what, ": ", database == nullptr ? "no memory" : sqlite3_errmsg(database)));
}

// Characters that end a path in a URI are written as such.
std::string UriOf(const std::string& path, absl::string_view options) {
  return absl::StrCat(
      "file:", absl::StrReplaceAll(path, {{"%", "%25"}, {"?", "%3f"}, {"#", "%23"}}), "?", options);
}

// Nothing in the file may have something done: no views, triggers or functions of its own.
void BeCareful(sqlite3* database) {
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, static_cast<int>(kMostBagBytes));
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_exec(database, "PRAGMA cell_size_check=ON; PRAGMA mmap_size=0", nullptr, nullptr,
               nullptr);
}

absl::StatusOr<Database> OpenDatabase(const std::string& path, const std::string& name,
                                      absl::string_view options) {
  sqlite3* opened = nullptr;
  const int result =
      sqlite3_open_v2(UriOf(path, options).c_str(), &opened,
                      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_FULLMUTEX, nullptr);
  Database database(opened, &sqlite3_close);
  if (result != SQLITE_OK) return SqliteError(name, opened, "can't be opened");
  BeCareful(opened);
  return database;
}

absl::StatusOr<Statement> Prepare(const std::string& path, sqlite3* database, const char* sql) {
  sqlite3_stmt* prepared = nullptr;
  if (sqlite3_prepare_v2(database, sql, -1, &prepared, nullptr) != SQLITE_OK) {
    return SqliteError(path, database, "no bag of rosbag2");
  }
  return Statement(prepared, &sqlite3_finalize);
}

std::string TextOf(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  if (text == nullptr) return "";
  return CleanName({text, static_cast<size_t>(sqlite3_column_bytes(row, column))});
}

constexpr char kSelectMessages[] = "SELECT id, topic_id, timestamp FROM messages ORDER BY id";

class SqliteFile : public BagFile {
 public:
  SqliteFile(std::string path, Database database)
      : path_(std::move(path)), database_(std::move(database)) {}

  // Reads the topics, and tries whether messages can be read.
  absl::Status Prepare();

  absl::string_view format() const override { return "SQLite (rosbag2)"; }
  void Scan(Use use) override;
  const std::vector<BagChannel>& channels() const override { return channels_; }
  const std::vector<std::string>& notes() const override { return notes_.all(); }
  absl::StatusOr<std::string> Read(const BagPlace& place) const override {
    absl::MutexLock lock(&mutex_);
    Blob blob(nullptr, &sqlite3_blob_close);
    return ReadMessage(static_cast<int64_t>(place.offset), kMostBagBytes, blob);
  }
  void Note(std::string note) { notes_.Add(std::move(note)); }

 private:
  // Opens the message into `blob`, or moves that to it, and reads its first bytes.
  absl::StatusOr<std::string> ReadMessage(int64_t id, uint64_t most, Blob& blob) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // A message of the table; nullopt where it can't be read, which is noted.
  struct Row {
    ScannedMessage message;
    std::string head;
  };
  std::optional<Row> TakeRow(sqlite3_stmt* row, Blob& blob) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string path_;
  mutable absl::Mutex mutex_;
  const Database database_;
  std::map<int64_t, size_t> numbers_;  // Of channels, by the file's ids.
  std::vector<BagChannel> channels_;
  BagNotes notes_;
};

absl::Status SqliteFile::Prepare() {
  // A view of that name could be anything.
  ASSIGN_OR_RETURN(const Statement tables,
                   client_agent::Prepare(path_, database_.get(),
                                         "SELECT count(*) FROM sqlite_master WHERE type = 'table' "
                                         "AND name IN ('topics', 'messages')"));
  if (sqlite3_step(tables.get()) != SQLITE_ROW) {
    return SqliteError(path_, database_.get(), "can't be read");
  }
  if (sqlite3_column_int(tables.get(), 0) != 2) {
    return absl::InvalidArgumentError(
        absl::StrCat(path_, ": no bag of rosbag2: it has no tables topics and messages"));
  }
  ASSIGN_OR_RETURN(
      const Statement topics,
      client_agent::Prepare(path_, database_.get(),
                            "SELECT id, name, type, serialization_format FROM topics ORDER BY id"));
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(topics.get())) == SQLITE_ROW) {
    BagChannel channel{TextOf(topics.get(), 1), PlainTypeName(TextOf(topics.get(), 2)),
                       TextOf(topics.get(), 3), BagEncoding::kOther, ""};
    channel.encoding = EncodingOfName(channel.encoding_name);
    numbers_.emplace(sqlite3_column_int64(topics.get(), 0), channels_.size());
    channels_.push_back(std::move(channel));
  }
  if (result != SQLITE_DONE) return SqliteError(path_, database_.get(), "table topics");
  return client_agent::Prepare(path_, database_.get(), kSelectMessages).status();
}

absl::StatusOr<std::string> SqliteFile::ReadMessage(int64_t id, uint64_t most, Blob& blob) const {
  int result = SQLITE_ERROR;
  if (blob != nullptr) {
    result = sqlite3_blob_reopen(blob.get(), id);
  } else {
    sqlite3_blob* opened = nullptr;
    result = sqlite3_blob_open(database_.get(), "main", "messages", "data", id, 0, &opened);
    blob.reset(opened);
  }
  const std::string what = absl::StrCat("message with id ", id);
  if (result != SQLITE_OK) return SqliteError(path_, database_.get(), what);
  const uint64_t size = std::min(most, static_cast<uint64_t>(sqlite3_blob_bytes(blob.get())));
  std::string bytes(size, '\0');
  if (sqlite3_blob_read(blob.get(), bytes.data(), static_cast<int>(size), 0) == SQLITE_OK) {
    return bytes;
  }
  return SqliteError(path_, database_.get(), what);
}

std::optional<SqliteFile::Row> SqliteFile::TakeRow(sqlite3_stmt* row, Blob& blob) {
  const int64_t id = sqlite3_column_int64(row, 0);
  const auto channel = numbers_.find(sqlite3_column_int64(row, 1));
  if (channel == numbers_.end()) {
    notes_.Add(absl::StrCat(path_, ": message with id ", id, ": topic_id ",
                            sqlite3_column_int64(row, 1), " is not in the table topics"));
    return std::nullopt;
  }
  absl::StatusOr<std::string> head = ReadMessage(id, kBagHeadBytes, blob);
  if (!head.ok()) {
    blob.reset();  // One that failed can't be moved.
    notes_.Add(head.status());
    return std::nullopt;
  }
  const auto size = static_cast<uint32_t>(sqlite3_blob_bytes(blob.get()));
  return Row{{channel->second,
              sqlite3_column_int64(row, 2),
              {BagPlace::kNoChunk, size, static_cast<uint64_t>(id)},
              ""},
             *std::move(head)};
}

void SqliteFile::Scan(Use use) {
  absl::StatusOr<Statement> rows = client_agent::Prepare(path_, database_.get(), kSelectMessages);
  Blob blob(nullptr, &sqlite3_blob_close);
  int result = SQLITE_ROW;
  while (rows.ok() && result == SQLITE_ROW) {
    std::optional<Row> row;
    {
      absl::MutexLock lock(&mutex_);
      result = sqlite3_step(rows->get());
      if (result == SQLITE_ROW) row = TakeRow(rows->get(), blob);
    }
    if (!row.has_value()) continue;
    row->message.head = row->head;
    use(row->message);  // Who uses it may read more of the file.
  }
  if (rows.ok() && result == SQLITE_DONE) return;
  notes_.Add(SqliteError(path_, database_.get(), "table messages is damaged and ends early"));
}

absl::StatusOr<std::unique_ptr<SqliteFile>> TryToOpen(const std::string& path,
                                                      const std::string& name,
                                                      absl::string_view options) {
  ASSIGN_OR_RETURN(Database database, OpenDatabase(path, name, options));
  auto file = std::make_unique<SqliteFile>(name, std::move(database));
  RETURN_IF_ERROR(file->Prepare());
  return file;
}

}  // namespace

absl::StatusOr<std::unique_ptr<BagFile>> OpenSqliteFile(const std::string& path,
                                                        const std::string& name) {
  absl::StatusOr<std::unique_ptr<SqliteFile>> file = TryToOpen(path, name, "mode=ro");
  if (file.ok()) return *std::move(file);
  // A recorder that was killed leaves a log beside the file, which only who may write there can
  // take in.
  absl::StatusOr<std::unique_ptr<SqliteFile>> alone = TryToOpen(path, name, "immutable=1");
  if (!alone.ok()) return file.status();
  (*alone)->Note(absl::StrCat(file.status().message(), ": read without its log (", path,
                              "-wal): what was recorded last may be missing. Copy the bag's folder "
                              "to where you may write"));
  return *std::move(alone);
}

}  // namespace corbslam::client_agent
