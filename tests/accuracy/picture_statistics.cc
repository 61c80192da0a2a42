// picture_statistics VOCABULARY SOURCE... : what the pictures of sequences are like for SLAM, one
// row a source and the ratio of each to the first: how a simulated street compares with a recorded
// one. SOURCE as in docs ("kitti:DIR?frames=0:200").
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client_agent/source/recorded_sequence.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/map/feature_grid.h"
#include "slam/place/keyframe_database.h"
#include "slam/sensor/sensor.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::tests {

using client_agent::OpenSource;

namespace {

constexpr int kFeatures = 2000;
constexpr double kSearchRadius_px = 60;
constexpr int kMaxDistance = 50;

struct Frame {
  Features features;
  std::shared_ptr<const Words> words;
};

struct Statistics {
  double grey_mean = 0;
  double grey_deviation = 0;
  double keypoints = 0;    // Keypoints of a frame.
  double fine_share = 0;   // Share of these on the two finest levels.
  double depth_share = 0;  // Share with a stereo match (or depth).
  double close_share = 0;  // Share of those that is nearer than close_depth_m.
  double median_depth_m = 0;
  double matched_share = 0;      // Share found again in the next frame.
  double track_length = 0;       // Mean number of frames a feature is followed.
  double long_tracks_share = 0;  // Share of tracks over at least five frames.
  double self_recall = 0;        // Share of odd frames whose best even frame is a neighbour.
};

// Searches greedily in a window for the nearest descriptor that is clearly nearer than the second.
std::vector<int> MatchNext(const Camera& camera, const Features& from, const Features& to) {
  const FeatureGrid grid(camera, to.keypoints);
  std::vector<int> matches(from.keypoints.size(), -1);
  std::vector<uint32_t> near;
  std::vector<bool> taken(to.keypoints.size(), false);
  for (size_t i = 0; i < from.keypoints.size(); ++i) {
    const Keypoint& keypoint = from.keypoints[i];
    int best = 256;
    int second = 256;
    int best_index = -1;
    near.clear();
    grid.FindNear(to.keypoints, keypoint.x_px, keypoint.y_px, kSearchRadius_px, keypoint.octave - 1,
                  keypoint.octave + 1, near);
    for (const uint32_t j : near) {
      if (taken[j]) continue;
      const int distance = HammingDistance(from.descriptors[i], to.descriptors[j]);
      if (distance < best) {
        second = best;
        best = distance;
        best_index = static_cast<int>(j);
      } else if (distance < second) {
        second = distance;
      }
    }
    if (best > kMaxDistance || best > 0.85 * second) continue;
    matches[i] = best_index;
    taken[static_cast<size_t>(best_index)] = true;
  }
  return matches;
}

double SelfRecall(const std::vector<Frame>& frames) {
  KeyframeDatabase even;
  for (uint32_t i = 0; i < frames.size(); i += 2) even.Add({LocalMapId{1}, i}, frames[i].words);
  size_t found = 0;
  size_t asked = 0;
  for (size_t i = 1; i < frames.size(); i += 2) {
    ++asked;
    const auto best = even.Query(frames[i].words->bag, QueryOptions());
    if (best.empty()) continue;
    const auto index = static_cast<int64_t>(best[0].id.index);
    if (std::abs(index - static_cast<int64_t>(i)) <= 3) ++found;
  }
  return asked == 0 ? 0 : static_cast<double>(found) / static_cast<double>(asked);
}

// Sums over frames while they are read.
class Collector {
 public:
  explicit Collector(const Camera& camera) : camera_(camera) {}

  void Add(const cv::Mat& grey, Frame frame) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(grey, mean, deviation);
    sums_.grey_mean += mean[0];
    sums_.grey_deviation += deviation[0];
    CountKeypoints(frame.features);
    Follow(frame.features);
    frames_.push_back(std::move(frame));
  }

  Statistics Finish() {
    for (const int length : lengths_) EndTrack(length);
    Statistics result = sums_;
    const auto n = static_cast<double>(std::max<size_t>(frames_.size(), 1));
    for (double* const value : {&result.grey_mean, &result.grey_deviation, &result.keypoints,
                                &result.fine_share, &result.depth_share, &result.close_share}) {
      *value /= n;
    }
    result.matched_share /= std::max(n - 1, 1.0);
    if (!depths_.empty()) result.median_depth_m = MeanMedian(depths_);
    result.track_length = frames_followed_ / std::max(tracks_, 1.0);
    result.long_tracks_share = long_tracks_ / std::max(tracks_, 1.0);
    result.self_recall = SelfRecall(frames_);
    return result;
  }

 private:
  void CountKeypoints(const Features& features) {
    double with_depth = 0;
    double close = 0;
    double fine = 0;
    for (const Keypoint& keypoint : features.keypoints) {
      if (keypoint.octave < 2) ++fine;
      if (!keypoint.HasDepth()) continue;
      const double depth_m = DepthFromDisparity(camera_, keypoint.disparity_px);
      depths_.push_back(depth_m);
      ++with_depth;
      if (depth_m < camera_.close_depth_m) ++close;
    }
    const auto count = static_cast<double>(features.keypoints.size());
    sums_.keypoints += count;
    sums_.fine_share += fine / std::max(count, 1.0);
    sums_.depth_share += with_depth / std::max(count, 1.0);
    sums_.close_share += close / std::max(count, 1.0);
  }

  void EndTrack(int length) {
    tracks_ += 1;
    frames_followed_ += length;
    if (length >= 5) long_tracks_ += 1;
  }

  void Follow(const Features& next) {
    std::vector<int> lengths(next.keypoints.size(), 1);
    if (!frames_.empty()) {
      const std::vector<int> matches = MatchNext(camera_, frames_.back().features, next);
      double matched = 0;
      for (size_t i = 0; i < matches.size(); ++i) {
        if (matches[i] < 0) {
          EndTrack(lengths_[i]);
        } else {
          lengths[static_cast<size_t>(matches[i])] = lengths_[i] + 1;
          ++matched;
        }
      }
      sums_.matched_share += matched / std::max(static_cast<double>(matches.size()), 1.0);
    }
    lengths_ = std::move(lengths);
  }

  const Camera camera_;
  Statistics sums_;
  std::vector<Frame> frames_;
  std::vector<double> depths_;
  std::vector<int> lengths_;  // Length so far of the track of each feature of the last frame.
  double tracks_ = 0;
  double frames_followed_ = 0;
  double long_tracks_ = 0;
};

absl::StatusOr<Statistics> Compute(const std::string& spec, const Vocabulary& vocabulary) {
  ASSIGN_OR_RETURN(auto source, OpenSource(spec));
  SensorOptions options;
  options.orb.features = kFeatures;
  ASSIGN_OR_RETURN(auto sensor, MakeSensor(source->calibration(), options));
  Collector collector(sensor->camera());
  while (true) {
    ASSIGN_OR_RETURN(const std::optional<SensorImages> images, source->NextImages());
    if (!images.has_value()) break;
    ASSIGN_OR_RETURN(Features features, sensor->Process(*images));
    auto words = std::make_shared<Words>(vocabulary.Transform(features.descriptors));
    collector.Add(images->grey, {std::move(features), std::move(words)});
  }
  return collector.Finish();
}

struct Row {
  const char* name;
  double Statistics::*value;
};

constexpr Row kRows[] = {
    {"grey level, mean", &Statistics::grey_mean},
    {"grey level, deviation", &Statistics::grey_deviation},
    {"keypoints a frame", &Statistics::keypoints},
    {"share on the two finest levels", &Statistics::fine_share},
    {"share with depth (stereo match rate)", &Statistics::depth_share},
    {"share with depth, close", &Statistics::close_share},
    {"median depth, m", &Statistics::median_depth_m},
    {"share found again in the next frame", &Statistics::matched_share},
    {"mean track length, frames", &Statistics::track_length},
    {"share of tracks of 5 frames or more", &Statistics::long_tracks_share},
    {"recall of neighbours by words", &Statistics::self_recall},
};

absl::Status Run(const std::string& vocabulary_path, const std::vector<std::string>& sources) {
  ASSIGN_OR_RETURN(const auto vocabulary, Vocabulary::Load(vocabulary_path));
  std::vector<Statistics> columns;
  for (const std::string& source : sources) {
    ASSIGN_OR_RETURN(const Statistics statistics, Compute(source, *vocabulary));
    columns.push_back(statistics);
    std::printf("%zu: %s\n", columns.size(), source.c_str());
  }
  for (const Row& row : kRows) {
    std::printf("%-38s", row.name);
    const double first = columns.front().*row.value;
    for (const Statistics& column : columns) {
      std::printf(" %9.3f", column.*row.value);
      if (&column != &columns.front() && first != 0) {
        std::printf(" (%4.2f)", column.*row.value / first);
      }
    }
    std::printf("\n");
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  if (argc < 3) {
    std::fprintf(stderr, "usage: picture_statistics VOCABULARY SOURCE...\n");
    return 2;
  }
  const absl::Status status = corbslam::tests::Run(argv[1], {argv + 2, argv + argc});
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
