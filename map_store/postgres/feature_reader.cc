#include "map_store/postgres/feature_reader.h"

#include "absl/strings/str_cat.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/postgres/content_hash.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Keyframes have some 50 kB of features.
constexpr char kReadAhead[] =
    "SELECT k.local_map, k.keyframe, k.size, k.hash, p.bytes FROM"
    " (SELECT local_map, keyframe, size, hash FROM corbslam.keyframes WHERE mission_id = $1"
    " AND (local_map, keyframe) >= ($2, $3) ORDER BY local_map, keyframe LIMIT 64) AS k"
    " LEFT JOIN corbslam.payloads AS p ON p.mission_id = $1 AND p.hash = k.hash"
    " ORDER BY k.local_map, k.keyframe, p.piece";

}  // namespace

absl::Status FeatureReader::ReadAhead(KeyframeId id) {
  ASSIGN_OR_RETURN(const std::vector<SqlResult> read,
                   pool_.Read({{kReadAhead,
                                {SqlValue::Number(mission_id_), SqlValue::Bits(id.local_map.value),
                                 SqlValue::Number(id.index)}}}));
  ahead_.clear();
  const SqlResult& rows = read.front();
  for (int i = 0; i < rows.rows(); ++i) {
    Stored& stored = ahead_[{{rows.Bits(i, 0)}, static_cast<uint32_t>(rows.Number(i, 1))}];
    stored.size = rows.Bits(i, 2);
    stored.hash = rows.Text(i, 3);
    stored.bytes.append(rows.Bytes(i, 4));
  }
  return absl::OkStatus();
}

absl::StatusOr<Features> FeatureReader::Read(KeyframeId id) {
  if (!ahead_.contains(id)) RETURN_IF_ERROR(ReadAhead(id));
  const auto it = ahead_.find(id);
  if (it == ahead_.end()) {
    return absl::DataLossError(absl::StrCat("features of keyframe ", ToString(id), " are lost"));
  }
  const Stored& stored = it->second;
  if (stored.bytes.size() != stored.size || ContentHash(stored.bytes) != stored.hash) {
    return absl::DataLossError(absl::StrCat("features of keyframe ", ToString(id),
                                            " do not fit their checksum: they are damaged"));
  }
  return DecodeFeatures(stored.bytes);
}

}  // namespace corbslam::map_store
