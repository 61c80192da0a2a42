#include "client_agent/tracking/patch_sources.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace corbslam::client_agent {
namespace {

// The picture is cut into so many parts across.
constexpr int kPartsAcross = 16;
// Observations of a point that are looked at, the newest first.
constexpr int kMostTries = 4;

class Parts {
 public:
  explicit Parts(const Camera& camera)
      : side_px_(static_cast<double>(camera.width_px) / kPartsAcross),
        counts_(kPartsAcross * (static_cast<size_t>(camera.height_px / side_px_) + 1)) {}

  // Returns how many came before it in its part.
  size_t Count(const Eigen::Vector2d& pixel) {
    const auto column =
        std::min<size_t>(static_cast<size_t>(pixel.x() / side_px_), kPartsAcross - 1);
    const auto row = static_cast<size_t>(pixel.y() / side_px_);
    return counts_[std::min(row * kPartsAcross + column, counts_.size() - 1)]++;
  }

 private:
  const double side_px_;
  std::vector<size_t> counts_;
};

// Who sees a point, and with which keypoint; null: nobody with a picture.
struct Sight {
  const HalvedPicture* picture = nullptr;
  KeyframeId keyframe;
  uint32_t keypoint = 0;
};

Sight FindSight(const MapPoint& point, LocalMapId own, const KeyframePictures& pictures) {
  const auto& observations = point.observations;
  auto after = observations.upper_bound({own, std::numeric_limits<uint32_t>::max()});
  for (int i = 0; i < kMostTries && after != observations.begin(); ++i) {
    const auto& [id, keypoint] = *--after;
    if (id.local_map != own) return {};
    if (const HalvedPicture* picture = pictures.Find(id)) return {picture, id, keypoint};
  }
  return {};
}

// A point in view that somebody with a picture sees.
struct Candidate {
  size_t number = 0;  // Of those in its part of the picture.
  const PointInView* in_view = nullptr;
  const MapPoint* point = nullptr;
  Sight sight;
};

PatchSource SourceOf(const Map& map, const Candidate& candidate) {
  const Keyframe& keyframe = *map.FindKeyframe(candidate.sight.keyframe);
  return {.point = candidate.point->id,
          .position_in_map = candidate.point->position_in_map,
          .octave = candidate.in_view->view.octave,
          .picture = candidate.sight.picture,
          .source_from_map = keyframe.camera_from_map,
          .keypoint = keyframe.keypoints()[candidate.sight.keypoint],
          .descriptor = keyframe.descriptors()[candidate.sight.keypoint]};
}

}  // namespace

void KeyframePictures::Add(KeyframeId id, const HalvedPicture& picture) {
  HalvedPicture& kept = pictures_[id];
  for (int i = 0; i < HalvedPicture::kLevels; ++i) kept.levels[i] = picture.levels[i].clone();
  if (pictures_.size() > kMost) pictures_.erase(pictures_.begin());
}

const HalvedPicture* KeyframePictures::Find(KeyframeId id) const {
  const auto it = pictures_.find(id);
  return it == pictures_.end() ? nullptr : &it->second;
}

std::vector<PatchSource> FindPatchSources(const Map& map, LocalMapId own,
                                          const std::vector<PointInView>& points,
                                          const Camera& camera, const KeyframePictures& pictures,
                                          size_t most) {
  std::vector<Candidate> candidates;
  Parts parts(camera);
  for (const PointInView& in_view : points) {
    const MapPoint* const point = map.FindPoint(in_view.point.id);
    if (point == nullptr) continue;
    const Sight sight = FindSight(*point, own, pictures);
    if (sight.picture == nullptr) continue;
    candidates.push_back({parts.Count(in_view.view.pixel), &in_view, point, sight});
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::number);
  if (candidates.size() > most) candidates.resize(most);
  std::vector<PatchSource> sources;
  sources.reserve(candidates.size());
  for (const Candidate& candidate : candidates) sources.push_back(SourceOf(map, candidate));
  return sources;
}

}  // namespace corbslam::client_agent
