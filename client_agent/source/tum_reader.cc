#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/image_file.h"
#include "client_agent/source/tum_calibration.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

constexpr int64_t kMaxGap_ns = 20'000'000;

struct TimedFile {
  int64_t timestamp_ns = 0;
  std::string path;
};
struct RgbdFiles {
  int64_t timestamp_ns = 0;  // Of the grey picture.
  std::string grey;
  std::string depth;
};

// A line's fields; `count` of them, of which those at even places are times.
absl::StatusOr<std::vector<TimedFile>> ParseLine(const std::string& directory,
                                                 const std::string& path, int line,
                                                 absl::string_view text, size_t count) {
  const std::vector<absl::string_view> fields =
      absl::StrSplit(text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  if (fields.size() != count) {
    return LineError(path, line, absl::StrCat(fields.size(), " fields instead of ", count));
  }
  std::vector<TimedFile> files;
  for (size_t i = 0; i < count; i += 2) {
    const absl::StatusOr<int64_t> timestamp_ns = ParseSeconds(fields[i]);
    if (!timestamp_ns.ok()) {
      return LineError(path, line,
                       absl::StrCat("field ", i + 1, ": ", timestamp_ns.status().message()));
    }
    files.push_back({*timestamp_ns, absl::StrCat(directory, "/", fields[i + 1])});
  }
  return files;
}

absl::StatusOr<std::vector<RgbdFiles>> ReadAssociations(const std::string& directory,
                                                        const std::string& path) {
  std::vector<RgbdFiles> frames;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    ASSIGN_OR_RETURN(const std::vector<TimedFile> files, ParseLine(directory, path, line, text, 4));
    frames.push_back({files[0].timestamp_ns, files[0].path, files[1].path});
    return absl::OkStatus();
  }));
  return frames;
}

absl::StatusOr<std::vector<TimedFile>> ReadTimedFiles(const std::string& directory,
                                                      const std::string& name) {
  const std::string path = absl::StrCat(directory, "/", name);
  std::vector<TimedFile> files;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    ASSIGN_OR_RETURN(const std::vector<TimedFile> file, ParseLine(directory, path, line, text, 2));
    files.push_back(file[0]);
    return absl::OkStatus();
  }));
  std::stable_sort(files.begin(), files.end(), [](const TimedFile& a, const TimedFile& b) {
    return a.timestamp_ns < b.timestamp_ns;
  });
  return files;
}

// Pairs by growing difference in time, each file used once.
std::vector<RgbdFiles> Associate(const std::vector<TimedFile>& grey,
                                 const std::vector<TimedFile>& depth) {
  struct Candidate {
    int64_t gap_ns;
    size_t grey;
    size_t depth;
    auto operator<=>(const Candidate&) const = default;
  };
  std::vector<Candidate> candidates;
  size_t first = 0;
  for (size_t i = 0; i < grey.size(); ++i) {
    while (first < depth.size() && depth[first].timestamp_ns < grey[i].timestamp_ns - kMaxGap_ns) {
      ++first;
    }
    for (size_t k = first;
         k < depth.size() && depth[k].timestamp_ns <= grey[i].timestamp_ns + kMaxGap_ns; ++k) {
      candidates.push_back({std::abs(depth[k].timestamp_ns - grey[i].timestamp_ns), i, k});
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::set<size_t> used_depth;
  std::vector<const TimedFile*> chosen(grey.size(), nullptr);
  for (const Candidate& candidate : candidates) {
    if (chosen[candidate.grey] != nullptr || used_depth.contains(candidate.depth)) continue;
    chosen[candidate.grey] = &depth[candidate.depth];
    used_depth.insert(candidate.depth);
  }
  std::vector<RgbdFiles> frames;
  for (size_t i = 0; i < grey.size(); ++i) {
    if (chosen[i] != nullptr) {
      frames.push_back({grey[i].timestamp_ns, grey[i].path, chosen[i]->path});
    }
  }
  return frames;
}

absl::StatusOr<std::vector<RgbdFiles>> ListFrames(const std::string& directory) {
  const std::string associations = directory + "/associated.txt";
  std::error_code ignored;
  if (std::filesystem::exists(associations, ignored)) {
    return ReadAssociations(directory, associations);
  }
  ASSIGN_OR_RETURN(const std::vector<TimedFile> grey, ReadTimedFiles(directory, "rgb.txt"));
  ASSIGN_OR_RETURN(const std::vector<TimedFile> depth, ReadTimedFiles(directory, "depth.txt"));
  return Associate(grey, depth);
}

class TumReader : public FrameReader {
 public:
  TumReader(const RgbdCalibration& calibration, std::vector<RgbdFiles> frames)
      : calibration_(calibration), frames_(std::move(frames)) {}

  const SensorCalibration& calibration() const override { return calibration_; }
  size_t frame_count() const override { return frames_.size(); }
  int64_t timestamp_ns(size_t frame) const override { return frames_[frame].timestamp_ns; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    SensorImages images;
    images.timestamp_ns = frames_[frame].timestamp_ns;
    ASSIGN_OR_RETURN(images.grey, ReadGreyImage(frames_[frame].grey));
    ASSIGN_OR_RETURN(images.depth, ReadDepthImage(frames_[frame].depth));
    return images;
  }

 private:
  const SensorCalibration calibration_;
  const std::vector<RgbdFiles> frames_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenTum(const std::string& directory) {
  ASSIGN_OR_RETURN(std::vector<RgbdFiles> frames, ListFrames(directory));
  if (frames.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(directory, ": no picture has a depth image"));
  }
  ASSIGN_OR_RETURN(const cv::Mat first, ReadGreyImage(frames.front().grey));
  ASSIGN_OR_RETURN(const RgbdCalibration calibration,
                   ReadTumCalibration(directory, first.cols, first.rows));
  return std::make_unique<TumReader>(calibration, std::move(frames));
}

}  // namespace corbslam
