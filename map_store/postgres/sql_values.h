// Statements with their values, and what a server answers, all in binary: bigint, text and bytea
// are the only types of the journal's tables that pass.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_SQL_VALUES_H_
#define CORBSLAM_MAP_STORE_POSTGRES_SQL_VALUES_H_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

struct pg_result;

namespace corbslam::map_store {

// A value of a statement.
class SqlValue {
 public:
  static SqlValue Null() { return SqlValue(kText, "", true); }
  static SqlValue NoNumber() { return SqlValue(kNumber, "", true); }
  static SqlValue Number(int64_t number);
  // Numbers without a sign are stored as those with one that have the same bits.
  static SqlValue Bits(uint64_t number) { return Number(static_cast<int64_t>(number)); }
  static SqlValue Text(std::string text) { return SqlValue(kText, std::move(text), false); }
  static SqlValue Bytes(std::string bytes) { return SqlValue(kBytes, std::move(bytes), false); }

  uint32_t type() const { return type_; }
  const char* data() const { return is_null_ ? nullptr : bytes_.data(); }
  int size() const { return static_cast<int>(bytes_.size()); }

 private:
  // Numbers that PostgreSQL's catalogue gives types.
  static constexpr uint32_t kNumber = 20;
  static constexpr uint32_t kText = 25;
  static constexpr uint32_t kBytes = 17;

  SqlValue(uint32_t type, std::string bytes, bool is_null)
      : type_(type), bytes_(std::move(bytes)), is_null_(is_null) {}

  uint32_t type_;
  std::string bytes_;
  bool is_null_;
};

struct SqlStatement {
  const char* text;  // A literal.
  std::vector<SqlValue> values = {};
};
using SqlStatements = std::vector<SqlStatement>;

// The rows that a statement gave. A value of another type than is asked for is 0 or empty.
class SqlResult {
 public:
  explicit SqlResult(pg_result* result);

  int rows() const;
  // What was done, as "COMMIT" or "INSERT 0 1".
  std::string_view command() const;
  // How many rows an INSERT, UPDATE or DELETE changed.
  int64_t changed() const;
  bool IsNull(int row, int column) const;
  int64_t Number(int row, int column) const;
  uint64_t Bits(int row, int column) const { return static_cast<uint64_t>(Number(row, column)); }
  // Lives as long as this.
  std::string_view Bytes(int row, int column) const;
  std::string Text(int row, int column) const { return std::string(Bytes(row, column)); }

 private:
  std::shared_ptr<pg_result> result_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_SQL_VALUES_H_
