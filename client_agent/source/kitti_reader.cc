#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/calibration/kitti_calibration.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/imu_opening.h"
#include "client_agent/source/kitti_folders.h"
#include "client_agent/source/listed_reader.h"
#include "client_agent/source/lists/frame_rate.h"
#include "client_agent/source/lists/kitti_times.h"
#include "client_agent/source/lists/numbered_pictures.h"
#include "client_agent/source/pictures/image_file.h"
#include "client_agent/source/rig_opening.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using Numbered = std::map<size_t, std::string>;

struct Pictures {
  Numbered left;
  Numbered right;
};

std::vector<std::string> PathsOf(const Numbered& pictures) {
  std::vector<std::string> paths;
  for (const auto& [number, path] : pictures) paths.push_back(path);
  return paths;
}

absl::StatusOr<Pictures> ListPictures(const KittiFolders& folders, bool one_camera) {
  Pictures pictures;
  ASSIGN_OR_RETURN(pictures.left, ListNumberedPictures(folders.left, "", ""));
  // What isn't looked at is taken to be there.
  pictures.right = pictures.left;
  if (!one_camera) {
    ASSIGN_OR_RETURN(pictures.right, ListNumberedPictures(folders.right, "", ""));
  }
  for (const auto& [folder, list] :
       {std::pair(folders.left, &pictures.left), std::pair(folders.right, &pictures.right)}) {
    if (list->empty()) {
      return absl::NotFoundError(
          absl::StrCat("no picture in ", folder, " that is named by its number, as 000000.png"));
    }
  }
  return pictures;
}

// Notes the spare times: a part of a recording may come with the list of the whole.
void TellSpareTimes(const std::string& path, size_t spare, SourceDescription& description) {
  if (spare == 0) return;
  description.remarks.left_out.push_back(
      absl::StrCat("the last ", spare, " times of ", path, ", of which there is no picture"));
}

// Returns the times of the pictures from 0 on. Where there are fewer times than pictures, it is not
// known which ones are missing.
absl::StatusOr<std::vector<ListedTime>> TimesOf(const SourceSpec& spec, const std::string& path,
                                                size_t pictures, SourceDescription& description) {
  std::error_code ignored;
  if (spec.opening.fps.has_value()) {
    description.times_from = absl::StrCat("?fps=", *spec.opening.fps);
    return TimesAtRate(*spec.opening.fps, pictures);
  }
  if (!std::filesystem::exists(path, ignored)) return NoTimes(path);
  ASSIGN_OR_RETURN(std::vector<ListedTime> times, ReadKittiTimes(path));
  if (times.size() >= pictures) {
    TellSpareTimes(path, times.size() - pictures, description);
    times.resize(pictures);
    return times;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      path, ": ", times.size(), " times, but pictures are numbered up to ", pictures - 1,
      ": line n is the time of picture n - 1; add the missing ones or take the pictures out"));
}

std::string PathOf(const Numbered& pictures, size_t number, const std::string& folder) {
  const auto found = pictures.find(number);
  return found != pictures.end() ? found->second : absl::StrFormat("%s/%06d.png", folder, number);
}

absl::StatusOr<std::vector<ListedFrame>> ListFrames(const SourceSpec& spec,
                                                    const KittiFolders& folders,
                                                    const Pictures& pictures,
                                                    SourceDescription& description) {
  const size_t count = 1 + std::max(pictures.left.rbegin()->first, pictures.right.rbegin()->first);
  ASSIGN_OR_RETURN(const std::vector<ListedTime> times,
                   TimesOf(spec, folders.times, count, description));
  ASSIGN_OR_RETURN(Timeline timeline, BuildTimeline(folders.times, times));
  std::vector<ListedFrame> frames;
  for (size_t i = 0; i < timeline.kept.size(); ++i) {
    const size_t number = timeline.kept[i];
    frames.push_back({times[number].timestamp_ns, timeline.drive[i],
                      PathOf(pictures.left, number, folders.left),
                      PathOf(pictures.right, number, folders.right)});
  }
  description.remarks.Add(std::move(timeline.remarks));
  return frames;
}

// Takes what the recording's own file says.
absl::Status TakeCalibration(const SourceSpec& spec, const KittiFolders& folders,
                             const Pictures& pictures, ListedSequence& sequence) {
  ASSIGN_OR_RETURN(const cv::Mat first, ReadFirstGrey(PathsOf(pictures.left)));
  ASSIGN_OR_RETURN(FoundKittiCalibration found,
                   ReadKittiCalibration({folders.calibration, folders.left_row, folders.right_row,
                                         first.cols, first.rows, spec.opening.trust_calibration}));
  sequence.calibration = found.calibration;
  sequence.description.intrinsics_from =
      absl::StrCat(folders.calibration, " (", folders.left_row, ", ", folders.right_row, ")");
  sequence.description.remarks.Add(std::move(found.findings));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenKitti(const SourceSpec& spec) {
  ASSIGN_OR_RETURN(const bool one_camera, PlaysOneCamera(spec));
  ASSIGN_OR_RETURN(const KittiFolders folders, FindKittiFolders(spec, one_camera));
  ASSIGN_OR_RETURN(const Pictures pictures, ListPictures(folders, one_camera));
  ListedSequence sequence;
  const bool has_rig = !spec.opening.rig_file.empty();
  if (!has_rig) RETURN_IF_ERROR(TakeCalibration(spec, folders, pictures, sequence));
  ASSIGN_OR_RETURN(sequence.frames, ListFrames(spec, folders, pictures, sequence.description));
  if (has_rig) RETURN_IF_ERROR(TakeRig(spec, RigKind::kStereo, sequence));
  if (one_camera) LeaveOutSecond(sequence);
  RETURN_IF_ERROR(TakeImu(spec, /*own_list=*/"", sequence));
  sequence.times_file = folders.times;
  sequence.description.layout = folders.layout;
  return MakeListedReader(std::move(sequence));
}

}  // namespace corbslam::client_agent
