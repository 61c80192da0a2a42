// Converts what results of fusion workers are made of, to and from streams of chunks.
#ifndef CORBSLAM_SERVICES_CONVERT_WORK_RESULT_ITEMS_H_
#define CORBSLAM_SERVICES_CONVERT_WORK_RESULT_ITEMS_H_

#include <vector>

#include "absl/status/status.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "services/convert/work/map_view.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

// Holds the items of a result; each kind of result uses some of them.
struct ResultItems {
  std::vector<KeyframePose> poses;
  std::vector<PointPosition> positions;
  std::vector<FuseMapsResult::Merge> merges;
  std::vector<RejectedObservation> rejected;
  std::vector<Overlap> overlaps;
};

// Writes the items as serialised ResultChunks. Returns false if the sink did.
bool WriteResultItems(const ResultItems& items, const ChunkSink& sink);
// Appends the items of one chunk. INVALID_ARGUMENT names the item.
absl::Status ReadResultChunk(const v1::ResultChunk& chunk, ResultItems& items);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_WORK_RESULT_ITEMS_H_
