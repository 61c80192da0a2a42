// The tables of a journal on PostgreSQL: the SQL that makes them, and the check that they are
// there. docs/fleet.md says who runs it. Only what PostgreSQL, CockroachDB and YugabyteDB have in
// common is used.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_SCHEMA_H_
#define CORBSLAM_MAP_STORE_POSTGRES_SCHEMA_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::map_store {
class SqlPool;

// What this program writes. A version that the program before can't work with raises the second
// number of the table schema_versions with it.
inline constexpr int64_t kSchemaVersion = 3;

// Returns the SQL that makes the tables, or brings older ones to kSchemaVersion, and gives the role
// the rights that a store needs and no others. It may be run again. INVALID_ARGUMENT: the role's
// name has other characters than lower-case letters, digits and underscores.
absl::StatusOr<std::string> MakeSchemaSql(const std::string& role);

// Returns FAILED_PRECONDITION, with what to do, if the tables are not there, or not such that this
// program works with them.
absl::Status CheckSchema(SqlPool& pool);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_SCHEMA_H_
