#include "map_store/postgres/sql_values.h"

#include <libpq-fe.h>

#include "absl/strings/numbers.h"

namespace corbslam::map_store {

SqlValue SqlValue::Number(int64_t number) {
  std::string bytes(sizeof(number), '\0');
  auto rest = static_cast<uint64_t>(number);
  for (size_t i = bytes.size(); i-- > 0; rest >>= 8) bytes[i] = static_cast<char>(rest);
  return SqlValue(kNumber, std::move(bytes), false);
}

SqlResult::SqlResult(pg_result* result) : result_(result, &PQclear) {}

int SqlResult::rows() const { return PQntuples(result_.get()); }

std::string_view SqlResult::command() const { return PQcmdStatus(result_.get()); }

int64_t SqlResult::changed() const {
  int64_t changed = 0;
  return absl::SimpleAtoi(PQcmdTuples(result_.get()), &changed) ? changed : 0;
}

bool SqlResult::IsNull(int row, int column) const {
  return PQgetisnull(result_.get(), row, column) != 0;
}

int64_t SqlResult::Number(int row, int column) const {
  const std::string_view bytes = Bytes(row, column);
  if (bytes.size() != sizeof(int64_t)) return 0;
  uint64_t number = 0;
  for (const char byte : bytes) number = (number << 8) | static_cast<uint8_t>(byte);
  return static_cast<int64_t>(number);
}

std::string_view SqlResult::Bytes(int row, int column) const {
  if (row >= rows()) return {};
  return {PQgetvalue(result_.get(), row, column),
          static_cast<size_t>(PQgetlength(result_.get(), row, column))};
}

}  // namespace corbslam::map_store
