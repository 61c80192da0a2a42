// Writes responses of WatchMap for tests, by hand or at random.
#ifndef CORBSLAM_SERVICES_VIEWER_TESTING_MAP_CHANGES_H_
#define CORBSLAM_SERVICES_VIEWER_TESTING_MAP_CHANGES_H_

#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "corbslam/v1/map_store_service.pb.h"
#include "services/convert/ids.h"
#include "slam/util/ids.h"

namespace corbslam::testing {

inline constexpr LocalMapId kFirst{11};
inline constexpr LocalMapId kSecond{22};

// Writes one response; items belong to the island that was named last.
class ChangesWriter {
 public:
  explicit ChangesWriter(uint64_t version);

  ChangesWriter& Remove(LocalMapId island);
  ChangesWriter& Island(LocalMapId id, const std::vector<LocalMapId>& local_maps, bool anew);
  // The translation is along x.
  ChangesWriter& Keyframe(KeyframeId id, double translation);
  ChangesWriter& RemoveKeyframe(KeyframeId id);
  ChangesWriter& Point(MapPointId id, float x);
  ChangesWriter& RemovePoint(MapPointId id);
  v1::WatchMapResponse Take();

 private:
  v1::WatchMapResponse::Island& island();
  // Columns of ids hold differences, so that they are written at the end.
  void WriteColumns();

  v1::WatchMapResponse changes_;
  services::SlotWriter slots_;
  std::vector<MapPointId> points_;
  std::vector<MapPointId> removed_points_;
};

// The life of a mission of five local maps, whose islands merge and fall apart.
class RandomChanges {
 public:
  explicit RandomChanges(int seed) : random_(static_cast<uint32_t>(seed)) {}

  v1::WatchMapResponse Next();

 private:
  struct Island {
    std::set<LocalMapId> local_maps;
    std::set<KeyframeId> keyframes;
    std::set<MapPointId> points;
  };

  uint32_t Draw(uint32_t below) { return static_cast<uint32_t>(random_() % below); }
  void TellAll(LocalMapId id, ChangesWriter& writer);
  void Begin(LocalMapId id, ChangesWriter& writer);
  void Merge(ChangesWriter& writer);
  void FallApart(ChangesWriter& writer);
  void Change(ChangesWriter& writer);

  std::mt19937 random_;
  uint64_t version_ = 0;
  std::map<LocalMapId, Island> islands_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_VIEWER_TESTING_MAP_CHANGES_H_
