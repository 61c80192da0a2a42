// Adds the map store's limits as flags.
#ifndef CORBSLAM_SERVICES_PROGRAMS_LIMIT_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_LIMIT_FLAGS_H_

#include <CLI/CLI.hpp>

#include "map_store/options/options.h"
#include "services/map_store_service/streams/stream_limits.h"

namespace corbslam::services {

// Adds --max-... (docs/limits.md). The options must outlive the parsing; each checks itself.
void AddStoreLimitFlags(CLI::App& app, map_store::MapStoreOptions& options);
void AddStreamLimitFlags(CLI::App& app, StreamLimitOptions& options);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_LIMIT_FLAGS_H_
