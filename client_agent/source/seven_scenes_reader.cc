#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/imu_opening.h"
#include "client_agent/source/listed_reader.h"
#include "client_agent/source/lists/frame_rate.h"
#include "client_agent/source/lists/numbered_pictures.h"
#include "client_agent/source/rgbd_opening.h"
#include "client_agent/source/rig_opening.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

absl::StatusOr<std::vector<ListedFrame>> ListFrames(const SourceSpec& spec) {
  ASSIGN_OR_RETURN(const auto colour, ListNumberedPictures(spec.directory, "frame-", ".color"));
  ASSIGN_OR_RETURN(const auto depth, ListNumberedPictures(spec.directory, "frame-", ".depth"));
  if (colour.empty()) {
    return absl::NotFoundError(
        absl::StrCat(spec.directory,
                     ": no frame-000000.color.png and so on; 7-Scenes keeps them "
                     "in the folders seq-01, seq-02, ..."));
  }
  if (!spec.opening.fps.has_value()) return NoTimes(spec.directory + "/times.txt");
  const std::vector<ListedTime> times = TimesAtRate(*spec.opening.fps, colour.rbegin()->first + 1);
  std::vector<ListedFrame> frames;
  for (const auto& [number, path] : colour) {
    const auto found = depth.find(number);
    frames.push_back({times[number].timestamp_ns, 0, path,
                      found != depth.end()
                          ? found->second
                          : absl::StrFormat("%s/frame-%06d.depth.png", spec.directory, number)});
  }
  return frames;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> OpenSevenScenes(const SourceSpec& spec) {
  ListedSequence sequence;
  ASSIGN_OR_RETURN(sequence.frames, ListFrames(spec));
  ASSIGN_OR_RETURN(const bool one_camera, PlaysOneCamera(spec));
  RETURN_IF_ERROR(CalibrateRgbd(spec, sequence));
  if (one_camera) LeaveOutSecond(sequence);
  RETURN_IF_ERROR(TakeImu(spec, /*own_list=*/"", sequence));
  sequence.description.layout = "7-Scenes";
  sequence.description.times_from = absl::StrCat("?fps=", *spec.opening.fps);
  sequence.times_file = spec.directory;
  return MakeListedReader(std::move(sequence));
}

}  // namespace corbslam::client_agent
