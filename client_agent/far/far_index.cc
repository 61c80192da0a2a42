#include "client_agent/far/far_index.h"

#include <algorithm>
#include <limits>

namespace corbslam::client_agent {

void FarIndex::Add(const std::vector<FarPlace>& places) {
  for (const FarPlace& place : places) {
    centres_[place.id] = place.centre;
    if (place.words == nullptr || added_++ % stride_ != 0) continue;
    auto words = std::make_shared<Words>();
    words->bag = place.words->bag;
    bags_.Add(place.id, std::move(words));
    with_bag_.push_back(place.id);
    if (with_bag_.size() > max_bags_) Thin();
  }
}

void FarIndex::Thin() {
  std::vector<KeyframeId> kept;
  for (size_t i = 0; i < with_bag_.size(); ++i) {
    if (i % 2 == 0) {
      kept.push_back(with_bag_[i]);
    } else {
      bags_.Remove(with_bag_[i]);
    }
  }
  with_bag_ = std::move(kept);
  stride_ *= 2;
}

void FarIndex::Remove(LocalMapId local_map) {
  const auto is_of_it = [local_map](KeyframeId id) { return id.local_map == local_map; };
  std::erase_if(centres_, [&](const auto& item) { return is_of_it(item.first); });
  std::erase_if(with_bag_, [&](KeyframeId id) { return is_of_it(id) && bags_.Remove(id); });
}

void FarIndex::Clear() {
  centres_.clear();
  with_bag_.clear();
  bags_ = KeyframeDatabase();
  stride_ = kFirstStride;
  added_ = 0;
}

std::vector<FarIndex::Near> FarIndex::Nearest(std::span<const Eigen::Vector3d> points,
                                              double radius, size_t count) const {
  std::vector<Near> near;
  for (const auto& [id, centre] : centres_) {
    double least = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& point : points) least = std::min(least, (centre - point).norm());
    if (least <= radius && least < std::numeric_limits<double>::infinity()) {
      near.push_back({id, least});
    }
  }
  const auto is_nearer = [](const Near& a, const Near& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.id < b.id;
  };
  const size_t kept = std::min(count, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(kept), near.end(),
                    is_nearer);
  near.resize(kept);
  return near;
}

std::optional<Eigen::Vector3d> FarIndex::Recognise(const BagOfWords& bag,
                                                   double least_score) const {
  QueryOptions options;
  options.min_score = least_score;
  options.max_results = 1;
  const std::vector<PlaceCandidate> found = bags_.Query(bag, options);
  if (found.empty()) return std::nullopt;
  return centres_.at(found.front().id);
}

}  // namespace corbslam::client_agent
