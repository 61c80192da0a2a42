// Unpacks what bags hold compressed.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_UNPACK_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_UNPACK_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// `compression` is "zstd", "lz4" (its frames) or "bz2". With `size` there must be as many bytes;
// without, as many as kMostBagBytes. Memory grows with what is really there, whatever `size` says.
// INVALID_ARGUMENT says what is wrong, and UNIMPLEMENTED names another compression.
absl::StatusOr<std::string> Unpack(absl::string_view compression, absl::string_view packed,
                                   std::optional<uint64_t> size);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_UNPACK_H_
