// Implements TrainFromPictures, ExtractDescriptors and ListPictures.
#include <algorithm>
#include <array>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/trainer.h"

namespace corbslam {
namespace {

absl::StatusOr<cv::Mat> ReadGrey(const std::string& path) {
  cv::Mat grey;
  try {
    grey = cv::imread(path, cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", error.what()));
  }
  if (grey.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": no image"));
  return grey;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> ListPictures(const std::string& folder) {
  constexpr std::array<const char*, 4> kEndings = {".png", ".jpg", ".jpeg", ".pgm"};
  std::vector<std::string> paths;
  std::error_code error;
  for (auto entry = std::filesystem::directory_iterator(folder, error);
       !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const std::string ending = absl::AsciiStrToLower(entry->path().extension().string());
    if (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end()) {
      paths.push_back(entry->path().string());
    }
  }
  if (paths.empty()) {
    return absl::NotFoundError(
        absl::StrCat("no pictures in ", folder, error ? ": " + error.message() : ""));
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

absl::StatusOr<PictureDescriptors> ExtractDescriptors(const std::vector<std::string>& paths,
                                                      const OrbOptions& orb,
                                                      const TrainingProgress& progress) {
  RETURN_IF_ERROR(orb.Validate());
  OrbExtractor extractor(orb);
  ImagePyramid pyramid;
  PictureDescriptors pictures;
  for (const std::string& path : paths) {
    if (progress) progress("features", pictures.size(), paths.size());
    ASSIGN_OR_RETURN(const cv::Mat grey, ReadGrey(path));
    Features features;
    if (absl::Status status = extractor.Extract(grey, features, pyramid); !status.ok()) {
      return absl::Status(status.code(), absl::StrCat(path, ": ", status.message()));
    }
    pictures.push_back(std::move(features.descriptors));
  }
  return pictures;
}

absl::StatusOr<VocabularyTree> TrainFromPictures(const std::vector<std::string>& paths,
                                                 const OrbOptions& orb,
                                                 const TrainingOptions& options,
                                                 const TrainingProgress& progress) {
  ASSIGN_OR_RETURN(const PictureDescriptors pictures, ExtractDescriptors(paths, orb, progress));
  return TrainVocabulary(options, pictures, progress);
}

}  // namespace corbslam
