#include <filesystem>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/imu_opening.h"
#include "client_agent/source/listed_reader.h"
#include "client_agent/source/lists/rgbd_lists.h"
#include "client_agent/source/rgbd_opening.h"
#include "client_agent/source/rig_opening.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

struct Listed {
  std::vector<RgbdPair> pairs;
  std::string file;  // The file that gave the times.
};

absl::Status NoLists(const std::string& directory) {
  return absl::NotFoundError(
      absl::StrCat(directory, ": neither associated.txt nor associations.txt nor ", directory,
                   "/rgb.txt with depth.txt, which say which picture goes with which depth image"));
}

// Returns the pictures alone: of rgb.txt, which lists those without a depth image too, where that
// is there.
absl::StatusOr<Listed> ReadPictures(const std::string& directory, SourceRemarks& remarks) {
  Listed listed;
  listed.file = directory + "/rgb.txt";
  std::error_code ignored;
  if (std::filesystem::exists(listed.file, ignored)) {
    ASSIGN_OR_RETURN(listed.pairs, ListPicturesAlone(directory, remarks));
    return listed;
  }
  listed.file = FindAssociations(directory);
  if (listed.file.empty()) return NoLists(directory);
  ASSIGN_OR_RETURN(listed.pairs, ReadAssociations(directory, listed.file, 0, remarks));
  return listed;
}

absl::StatusOr<Listed> ReadLists(const std::string& directory, int64_t depth_offset_ns,
                                 SourceRemarks& remarks) {
  Listed listed;
  listed.file = FindAssociations(directory);
  if (!listed.file.empty()) {
    ASSIGN_OR_RETURN(listed.pairs,
                     ReadAssociations(directory, listed.file, depth_offset_ns, remarks));
    return listed;
  }
  std::error_code ignored;
  listed.file = directory + "/rgb.txt";
  if (!std::filesystem::exists(listed.file, ignored)) return NoLists(directory);
  ASSIGN_OR_RETURN(listed.pairs, PairLists(directory, depth_offset_ns, remarks));
  return listed;
}

absl::StatusOr<std::vector<ListedFrame>> ListFrames(const Listed& listed, SourceRemarks& remarks) {
  std::vector<ListedTime> times;
  for (const RgbdPair& pair : listed.pairs) times.push_back({pair.timestamp_ns, pair.line});
  ASSIGN_OR_RETURN(Timeline timeline, BuildTimeline(listed.file, times));
  std::vector<ListedFrame> frames;
  for (size_t i = 0; i < timeline.kept.size(); ++i) {
    const RgbdPair& pair = listed.pairs[timeline.kept[i]];
    frames.push_back({pair.timestamp_ns, timeline.drive[i], pair.grey, pair.depth});
  }
  remarks.Add(std::move(timeline.remarks));
  return frames;
}

// Returns the list that a robot's recording has; empty where there is none.
std::string FindImuList(const std::string& directory) {
  std::error_code ignored;
  const std::string list = directory + "/imu0/data.csv";
  return std::filesystem::exists(list, ignored) ? list : "";
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenTum(const SourceSpec& spec) {
  const std::string& directory = spec.directory;
  ListedSequence sequence;
  SourceDescription& description = sequence.description;
  ASSIGN_OR_RETURN(const bool one_camera, PlaysOneCamera(spec));
  ASSIGN_OR_RETURN(const int64_t depth_offset_ns, SecondTimeOffsetOf_ns(spec));
  ASSIGN_OR_RETURN(const Listed listed,
                   one_camera ? ReadPictures(directory, description.remarks)
                              : ReadLists(directory, depth_offset_ns, description.remarks));
  sequence.paired_by_time = true;
  ASSIGN_OR_RETURN(sequence.frames, ListFrames(listed, description.remarks));
  RETURN_IF_ERROR(CalibrateRgbd(spec, sequence));
  if (one_camera) LeaveOutSecond(sequence);
  RETURN_IF_ERROR(TakeImu(spec, FindImuList(directory), sequence));
  description.layout = one_camera ? "TUM RGB-D, pictures alone" : "TUM RGB-D";
  sequence.times_file = listed.file;
  return MakeListedReader(std::move(sequence));
}

}  // namespace corbslam::client_agent
