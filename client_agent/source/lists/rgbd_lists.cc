#include "client_agent/source/lists/rgbd_lists.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <set>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/lists/timed_files.h"
#include "client_agent/source/pictures/image_file.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

constexpr int64_t kMaxGap_ns = 20'000'000;
// Given pairs are believed further than pairs that are searched.
constexpr int64_t kMaxGivenGap_ns = 50'000'000;

bool IsInDepthFolder(const std::string& directory, const std::string& path) {
  const std::vector<std::string> parts =
      absl::StrSplit(path.substr(directory.size()), '/', absl::SkipEmpty());
  return parts.size() > 1 && absl::StartsWithIgnoreCase(parts.front(), "depth");
}

// Tells the depth image by the folders' names, else by what the files are.
absl::StatusOr<bool> IsDepthFirst(const std::string& directory, const std::string& path,
                                  const std::vector<TimedFile>& line) {
  const bool first = IsInDepthFolder(directory, line[0].path);
  if (first != IsInDepthFolder(directory, line[1].path)) return first;
  const bool first_has_16 = ReadDepthImage(line[0].path).ok();
  const bool second_has_16 = ReadDepthImage(line[1].path).ok();
  if (first_has_16 != second_has_16) return first_has_16;
  return LineError(
      path, line[0].line,
      absl::StrCat("which is the depth image, ", line[0].path, " or ", line[1].path,
                   "? Neither lies in a folder depth/, ", first_has_16 ? "both have" : "none has",
                   " one channel of 16 bits"));
}

absl::Status AllFarApart(const std::string& path, const RgbdPair& first) {
  return LineError(
      path, first.line,
      absl::StrCat("the picture is of ", FormatSeconds(first.timestamp_ns),
                   " s, its depth image of ", FormatSeconds(first.depth_timestamp_ns),
                   " s, and so for all: must be at most ", kMaxGivenGap_ns / 1000000, " ms apart"));
}

// Takes out the pairs that are too far apart in time.
absl::Status LeaveOutFarApart(const std::string& path, std::vector<RgbdPair>& pairs,
                              SourceRemarks& remarks) {
  const auto is_far = [](const RgbdPair& pair) {
    return std::abs(pair.timestamp_ns - pair.depth_timestamp_ns) > kMaxGivenGap_ns;
  };
  const auto first = std::find_if(pairs.begin(), pairs.end(), is_far);
  if (first == pairs.end()) return absl::OkStatus();
  const RgbdPair example = *first;
  const size_t all = pairs.size();
  std::erase_if(pairs, is_far);
  if (pairs.empty()) return AllFarApart(path, example);
  const std::string text = absl::StrCat(
      all - pairs.size(), " of ", all, " pairs are more than ", kMaxGivenGap_ns / 1000000,
      " ms apart in time, the first in ", path, ":", example.line);
  remarks.left_out.push_back(text);
  remarks.findings.push_back({FindingLevel::kWarning, "pairs-far-apart",
                              absl::StrCat(text, ": these frames are left out")});
  return absl::OkStatus();
}

// Returns indices of pictures and depth images, by growing difference in time, each used once.
std::vector<std::pair<size_t, size_t>> Associate(const std::vector<TimedFile>& grey,
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
  std::set<size_t> used_grey;
  std::set<size_t> used_depth;
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const Candidate& candidate : candidates) {
    if (used_grey.contains(candidate.grey) || used_depth.contains(candidate.depth)) continue;
    pairs.push_back({candidate.grey, candidate.depth});
    used_grey.insert(candidate.grey);
    used_depth.insert(candidate.depth);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

absl::Status NoPairs(const std::string& directory, const std::vector<TimedFile>& grey,
                     const std::vector<TimedFile>& depth) {
  const auto span = [](const std::vector<TimedFile>& files) {
    if (files.empty()) return std::string("nothing");
    return absl::StrCat(FormatSeconds(files.front().timestamp_ns), " to ",
                        FormatSeconds(files.back().timestamp_ns), " s");
  };
  return absl::InvalidArgumentError(
      absl::StrCat(directory, ": no picture has a depth image within ", kMaxGap_ns / 1000000,
                   " ms: rgb.txt lists ", span(grey), ", depth.txt ", span(depth)));
}

}  // namespace

std::string FindAssociations(const std::string& directory) {
  for (const char* name :
       {"associated.txt", "associations.txt", "association.txt", "associate.txt"}) {
    std::string path = absl::StrCat(directory, "/", name);
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) return path;
  }
  return "";
}

absl::StatusOr<std::vector<RgbdPair>> ReadAssociations(const std::string& directory,
                                                       const std::string& path,
                                                       int64_t depth_offset_ns,
                                                       SourceRemarks& remarks) {
  ASSIGN_OR_RETURN(const auto lines, ReadTimedFileLines(directory, path, 2));
  if (lines.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": lists no frame"));
  ASSIGN_OR_RETURN(const bool depth_first, IsDepthFirst(directory, path, lines.front()));
  std::vector<RgbdPair> pairs;
  for (const std::vector<TimedFile>& line : lines) {
    const TimedFile& grey = line[depth_first ? 1 : 0];
    const TimedFile& depth = line[depth_first ? 0 : 1];
    pairs.push_back({grey.timestamp_ns, depth.timestamp_ns + depth_offset_ns, grey.line, grey.path,
                     depth.path});
  }
  RETURN_IF_ERROR(LeaveOutFarApart(path, pairs, remarks));
  return pairs;
}

absl::StatusOr<std::vector<RgbdPair>> ListPicturesAlone(const std::string& directory,
                                                        SourceRemarks& remarks) {
  ASSIGN_OR_RETURN(const std::vector<TimedFile> pictures,
                   ReadTimedFiles(directory, directory + "/rgb.txt", remarks));
  std::vector<RgbdPair> alone;
  for (const TimedFile& picture : pictures) {
    alone.push_back({picture.timestamp_ns, 0, picture.line, picture.path, ""});
  }
  if (!alone.empty()) return alone;
  return absl::InvalidArgumentError(absl::StrCat(directory, "/rgb.txt: lists no picture"));
}

absl::StatusOr<std::vector<RgbdPair>> PairLists(const std::string& directory,
                                                int64_t depth_offset_ns, SourceRemarks& remarks) {
  ASSIGN_OR_RETURN(const std::vector<TimedFile> grey,
                   ReadTimedFiles(directory, directory + "/rgb.txt", remarks));
  ASSIGN_OR_RETURN(std::vector<TimedFile> depth,
                   ReadTimedFiles(directory, directory + "/depth.txt", remarks));
  for (TimedFile& file : depth) file.timestamp_ns += depth_offset_ns;
  std::vector<RgbdPair> pairs;
  for (const auto& [i, k] : Associate(grey, depth)) {
    pairs.push_back(
        {grey[i].timestamp_ns, depth[k].timestamp_ns, grey[i].line, grey[i].path, depth[k].path});
  }
  if (pairs.empty()) return NoPairs(directory, grey, depth);
  if (pairs.size() < grey.size()) {
    remarks.left_out.push_back(
        absl::StrCat(grey.size() - pairs.size(), " of ", grey.size(),
                     " pictures of rgb.txt, which have no depth image of their own within ",
                     kMaxGap_ns / 1000000, " ms"));
  }
  if (2 * pairs.size() < grey.size()) {
    remarks.findings.push_back(
        {FindingLevel::kWarning, "pairs-incomplete",
         absl::StrCat(directory, ": only ", pairs.size(), " of ", grey.size(),
                      " pictures of rgb.txt have a depth image within ", kMaxGap_ns / 1000000,
                      " ms")});
  }
  return pairs;
}

}  // namespace corbslam::client_agent
