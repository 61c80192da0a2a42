#include "client_agent/source/rgbd_opening.h"

#include <utility>

#include "client_agent/source/pictures/image_file.h"
#include "slam/util/status_macros.h"

namespace corbslam {

absl::StatusOr<RgbdCalibrationQuery> MakeCalibrationQuery(const SourceSpec& spec,
                                                          const std::vector<ListedFrame>& frames) {
  std::vector<std::string> pictures;
  for (const ListedFrame& frame : frames) pictures.push_back(frame.first);
  ASSIGN_OR_RETURN(const cv::Mat first, ReadFirstGrey(pictures));
  RgbdCalibrationQuery query;
  query.directory = spec.directory;
  query.file = spec.opening.calibration_file;
  query.camera = spec.opening.camera;
  query.first_picture = pictures.front();
  query.width_px = first.cols;
  query.height_px = first.rows;
  query.trust = spec.opening.trust_calibration;
  return query;
}

void TakeCalibration(FoundRgbdCalibration found, ListedSequence& sequence) {
  SourceDescription& description = sequence.description;
  sequence.calibration = found.calibration;
  description.intrinsics_from = std::move(found.from);
  description.depth_units_from = std::move(found.depth_units_from);
  description.remarks.Add(std::move(found.findings));
}

}  // namespace corbslam
