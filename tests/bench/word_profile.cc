// word_profile VOCABULARY FOLDER... : how often real pictures hold each word, which is what an
// inverted index costs. Prints, for all pictures of the folders together, the words of a picture,
// the words that two pictures share, the share of pictures that hold the word of each rank, and the
// Zipf-Mandelbrot law p(rank) ~ (rank + shift)^-exponent that fits them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "slam/features/orb_extractor.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/trainer.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::tests {
namespace {

constexpr int kFeatures = 2000;

struct Profile {
  size_t words = 0;  // Words of the vocabulary.
  size_t pictures = 0;
  double words_a_picture = 0;
  // Number of pictures that hold the word of each rank, most first.
  std::vector<int> pictures_with;
};

absl::StatusOr<Profile> Count(const Vocabulary& vocabulary, const std::vector<std::string>& paths) {
  OrbExtractor extractor(OrbOptions{.features = kFeatures});
  ImagePyramid pyramid;
  Profile profile;
  std::vector<int> pictures_with(vocabulary.nodes(), 0);
  for (const std::string& path : paths) {
    const cv::Mat grey = cv::imread(path, cv::IMREAD_GRAYSCALE);
    if (grey.empty()) return absl::NotFoundError("no picture " + path);
    Features features;
    RETURN_IF_ERROR(extractor.Extract(grey, features, pyramid));
    const Words words = vocabulary.Transform(features.descriptors);
    for (const WordWeight& word : words.bag) ++pictures_with[word.word];
    profile.words_a_picture += static_cast<double>(words.bag.size());
  }
  profile.words = vocabulary.words();
  profile.pictures = paths.size();
  profile.words_a_picture /= static_cast<double>(paths.size());
  std::sort(pictures_with.begin(), pictures_with.end(), std::greater<>());
  pictures_with.resize(profile.words);
  profile.pictures_with = std::move(pictures_with);
  return profile;
}

// Returns the words that two different pictures share, on average.
double SharedWords(const Profile& profile) {
  double pairs = 0;
  for (const int count : profile.pictures_with) pairs += static_cast<double>(count) * (count - 1);
  const auto n = static_cast<double>(profile.pictures);
  return pairs / (n * (n - 1));
}

struct Law {
  double exponent = 0;
  double shift = 0;
  double error = INFINITY;  // Mean square of log(share) over ranks spaced evenly in log(rank).
};

// Fits the exponent and the factor by least squares at each of a row of shifts.
Law Fit(const Profile& profile) {
  std::vector<std::pair<double, double>> rank_and_count;
  for (double rank = 1; rank <= static_cast<double>(profile.pictures_with.size()); rank *= 1.1) {
    const int count = profile.pictures_with[static_cast<size_t>(rank) - 1];
    if (count > 0) rank_and_count.emplace_back(std::floor(rank), count);
  }
  const auto n = static_cast<double>(rank_and_count.size());
  Law best;
  for (double shift = 1; shift < 1e6; shift *= 1.1) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
    for (const auto& [rank, count] : rank_and_count) {
      const double x = std::log(rank + shift);
      const double y = std::log(count);
      sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    const double error = (syy - sy * sy / n - slope * (sxy - sx * sy / n)) / n;
    if (error < best.error) best = {-slope, shift, error};
  }
  return best;
}

void Print(const Profile& profile) {
  std::printf("words %zu, pictures %zu, words a picture %.1f, shared by two %.1f\n", profile.words,
              profile.pictures, profile.words_a_picture, SharedWords(profile));
  for (size_t rank = 1; rank <= profile.words; rank *= 3) {
    std::printf("rank %7zu: %.4f of the pictures\n", rank,
                profile.pictures_with[rank - 1] / static_cast<double>(profile.pictures));
  }
  const Law law = Fit(profile);
  std::printf("exponent %.2f, shift %.0f, root mean square of log error %.2f\n", law.exponent,
              law.shift, std::sqrt(law.error));
}

absl::Status Run(const std::string& vocabulary_path, const std::vector<std::string>& folders) {
  ASSIGN_OR_RETURN(const auto vocabulary, Vocabulary::Load(vocabulary_path));
  std::vector<std::string> paths;
  for (const std::string& folder : folders) {
    ASSIGN_OR_RETURN(const std::vector<std::string> found, ListPictures(folder));
    paths.insert(paths.end(), found.begin(), found.end());
  }
  if (paths.size() < 2) return absl::InvalidArgumentError("fewer than two pictures");
  ASSIGN_OR_RETURN(const Profile profile, Count(*vocabulary, paths));
  Print(profile);
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s VOCABULARY FOLDER...\n", argv[0]);
    return 2;
  }
  const absl::Status status = corbslam::tests::Run(argv[1], {argv + 2, argv + argc});
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
