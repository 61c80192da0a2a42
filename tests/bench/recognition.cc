#include "tests/bench/recognition.h"

#include <algorithm>
#include <cstdint>
#include <numbers>

#include "slam/place/keyframe_database.h"

namespace corbslam::tests {
namespace {

constexpr double kSamePlace_m = 5.0;
constexpr double kSamePlace_rad = 30.0 * std::numbers::pi / 180.0;

}  // namespace

bool IsSamePlace(const SeenPlace& a, const SeenPlace& b) {
  if (a.scene != b.scene) return false;
  const Rigid3d b_from_a = b.world_from_camera.Inverse() * a.world_from_camera;
  return b_from_a.translation.norm() < kSamePlace_m &&
         RotationAngle(b_from_a.rotation) < kSamePlace_rad;
}

Recognition Recognise(const std::vector<SeenPlace>& database,
                      const std::vector<SeenPlace>& queries) {
  KeyframeDatabase words;
  for (uint32_t i = 0; i < database.size(); ++i) words.Add({LocalMapId{1}, i}, database[i].words);
  Recognition result;
  std::vector<double> right;
  for (const SeenPlace& query : queries) {
    const auto found = words.Query(query.words->bag, QueryOptions());
    if (found.empty()) continue;
    if (IsSamePlace(database[found[0].id.index], query)) {
      right.push_back(found[0].score);
    } else {
      result.worst_wrong = std::max(result.worst_wrong, found[0].score);
    }
  }
  result.right = right.size();
  result.found = static_cast<size_t>(
      std::ranges::count_if(right, [&](double score) { return score > result.worst_wrong; }));
  return result;
}

}  // namespace corbslam::tests
