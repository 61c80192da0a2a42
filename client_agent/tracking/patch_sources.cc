#include "client_agent/tracking/patch_sources.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

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

std::optional<PatchSource> SourceOf(const Map& map, LocalMapId own, const PointInView& in_view,
                                    const KeyframePictures& pictures) {
  const MapPoint* const point = map.FindPoint(in_view.point.id);
  if (point == nullptr) return std::nullopt;
  const auto& observations = point->observations;
  auto after = observations.upper_bound({own, std::numeric_limits<uint32_t>::max()});
  for (int i = 0; i < kMostTries && after != observations.begin(); ++i) {
    const auto& [id, keypoint] = *--after;
    if (id.local_map != own) return std::nullopt;
    const HalvedPicture* const picture = pictures.Find(id);
    if (picture == nullptr) continue;
    const Keyframe& keyframe = *map.FindKeyframe(id);
    return PatchSource{.point = point->id,
                       .position_in_map = point->position_in_map,
                       .octave = in_view.view.octave,
                       .picture = picture,
                       .source_from_map = keyframe.camera_from_map,
                       .keypoint = keyframe.keypoints()[keypoint],
                       .descriptor = keyframe.descriptors()[keypoint]};
  }
  return std::nullopt;
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
                                          const Camera& camera, const KeyframePictures& pictures) {
  std::vector<std::pair<size_t, PatchSource>> numbered;
  Parts parts(camera);
  for (const PointInView& in_view : points) {
    std::optional<PatchSource> source = SourceOf(map, own, in_view, pictures);
    if (source.has_value()) numbered.emplace_back(parts.Count(in_view.view.pixel), *source);
  }
  std::ranges::stable_sort(numbered, {}, &std::pair<size_t, PatchSource>::first);
  std::vector<PatchSource> sources;
  sources.reserve(numbered.size());
  for (auto& [number, source] : numbered) sources.push_back(std::move(source));
  return sources;
}

}  // namespace corbslam::client_agent
