// Removes what is left of missions that were deleted, and of those whose making was given up.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_DELETED_ROWS_H_
#define CORBSLAM_MAP_STORE_POSTGRES_DELETED_ROWS_H_

#include <functional>

#include "absl/status/status.h"

namespace corbslam::map_store {
class SqlPool;

// Takes missions that have been in the making for more than a day as deleted; and shortens the
// lists of missions.
absl::Status GiveUpUnfinished(SqlPool& pool);
// Removes the rows of deleted missions, some at a time, as long as `goes_on` says. Processes that
// do this at once share the work.
absl::Status RemoveDeletedRows(SqlPool& pool, const std::function<bool()>& goes_on);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_DELETED_ROWS_H_
