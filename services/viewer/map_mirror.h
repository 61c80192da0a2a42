// Keeps a mission's map as a map store tells it, to tell it to others.
#ifndef CORBSLAM_SERVICES_VIEWER_MAP_MIRROR_H_
#define CORBSLAM_SERVICES_VIEWER_MAP_MIRROR_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/status/status.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/convert/ids.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// Says up to where a picture of a mirror has been told. Default-constructed: nothing of it.
struct PictureCursor {
  bool points_begun = false;
  LocalMapId island = {};
  KeyframeId keyframe = {};
  MapPointId point = {};
  bool ended = false;
};

// The map of one mission as the responses of WatchMap make it. A value; not thread-safe.
class MapMirror {
 public:
  // INVALID_ARGUMENT names what can't be read; what came before it in the message is applied.
  absl::Status Apply(const v1::WatchMapResponse& changes);
  void Clear() { *this = MapMirror(); }

  uint64_t version() const { return version_; }
  size_t keyframes() const { return keyframes_; }
  size_t points() const { return points_; }

  // Returns the next piece of a picture of all there is, about `max_items` keyframes or points:
  // first the keyframes of all islands, then the points, if they are wanted. The mirror may change
  // between pieces. The piece that sets `cursor.ended` is the last one.
  v1::WatchMapResponse NextPiece(bool with_points, size_t max_items, PictureCursor& cursor) const;

 private:
  using Keyframe = v1::WatchMapResponse::IslandKeyframe;
  struct Point {
    std::array<float, 3> position = {};
    uint32_t observations = 0;
  };
  struct PlacedKeyframe {
    Keyframe place;  // Its references are to no slots: ids are here.
    KeyframeId parent;
  };
  struct Island {
    bool in_global_frame = false;
    std::vector<LocalMapId> local_maps;
    absl::btree_map<KeyframeId, PlacedKeyframe> keyframes;
    absl::btree_map<MapPointId, Point> points;
  };
  using Islands = absl::btree_map<LocalMapId, Island>;

  void Remove(LocalMapId island);
  absl::Status ApplyIsland(const v1::WatchMapResponse::Island& changes, const SlotReader& slots);
  absl::Status ApplyKeyframes(const v1::WatchMapResponse::Island& changes, const SlotReader& slots,
                              Island& island);
  absl::Status ApplyPoints(const v1::WatchMapResponse::Island& changes, const SlotReader& slots,
                           Island& island);
  // Both tell the rest of one island, as far as `room` goes, and return whether that was all of it.
  bool TellKeyframes(Islands::const_reference island, PictureCursor& cursor, size_t& room,
                     SlotWriter& slots, v1::WatchMapResponse& piece) const;
  bool TellPoints(Islands::const_reference island, PictureCursor& cursor, size_t& room,
                  SlotWriter& slots, v1::WatchMapResponse& piece) const;

  // The store tells how many keyframes see a point, as older ones do not.
  bool tells_observations_ = false;
  uint64_t version_ = 0;
  uint64_t revision_ = 0;
  absl::btree_map<LocalMapId, std::string> agents_;
  Islands islands_;
  size_t keyframes_ = 0;
  size_t points_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_MAP_MIRROR_H_
