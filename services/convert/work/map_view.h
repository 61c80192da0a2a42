// Converts views of the map to and from streams of chunks, for fusion workers.
#ifndef CORBSLAM_SERVICES_CONVERT_WORK_MAP_VIEW_H_
#define CORBSLAM_SERVICES_CONVERT_WORK_MAP_VIEW_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "services/convert/features.h"
#include "slam/map/map.h"
#include "slam/vocabulary/words.h"

namespace corbslam::services {

// Says what of a view is sent.
struct MapViewContent {
  bool descriptors = true;
  // False: only keypoints that see a point are sent, numbered anew; results never name keypoints.
  bool all_keypoints = true;
  bool covisibility = false;
};

// Takes serialised messages one after the other; returns false to end the writing.
using ChunkSink = std::function<bool(std::string chunk)>;

// Writes the view as MapChunks: keyframes first, then points, observations and edges; each keyframe
// with the node ids of the direct index where it has words. Returns false if the sink did.
bool WriteMapView(const Map& map, v1::MapView view, const MapViewContent& content,
                  const ChunkSink& sink);

// Writes for each keypoint its node of the direct index; ReadNodes returns the direct index again,
// and null where the message has none. The bag of words does not travel.
void WriteNodes(const Words& words, v1::Features* features);
std::shared_ptr<const Words> ReadNodes(const v1::Features& features);

// Builds a Map from its chunks. Not thread-safe.
class MapViewReader {
 public:
  // `descriptors_optional`: keyframes and points may come without their descriptors.
  // `covisibility`: whether it is counted, or comes with the view.
  MapViewReader(bool descriptors_optional, Covisibility covisibility)
      : descriptors_optional_(descriptors_optional), map_(covisibility) {}

  // Adds a chunk. INVALID_ARGUMENT names the item. After an error the reader is of no use.
  absl::Status Add(const v1::MapChunk& chunk);
  Map Take() && { return std::move(map_); }
  const Map& map() const { return map_; }

 private:
  const bool descriptors_optional_;
  CameraBook cameras_;
  Map map_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_WORK_MAP_VIEW_H_
