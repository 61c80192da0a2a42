#include "services/tool/mission/picture_search.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/store/call_status.h"
#include "services/convert/geometry.h"
#include "services/convert/limits.h"
#include "services/convert/resource_names.h"
#include "services/convert/work/locate_frame.h"
#include "slam/exchange/frame_location.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::StatusOr<std::vector<double>> ParseNumbers(absl::string_view what, const std::string& text,
                                                 size_t count) {
  std::vector<double> numbers;
  for (const absl::string_view word :
       absl::StrSplit(text, absl::ByAnyChar(" ,"), absl::SkipEmpty())) {
    double number = 0;
    if (!absl::SimpleAtod(word, &number) || !std::isfinite(number)) {
      return absl::InvalidArgumentError(
          absl::StrCat(what, " is \"", text, "\": \"", word, "\" is no number"));
    }
    numbers.push_back(number);
  }
  if (numbers.size() == count) return numbers;
  return absl::InvalidArgumentError(
      absl::StrCat(what, " is \"", text, "\", must have ", count, " numbers"));
}

// A file that is too large is read no further than that shows.
absl::StatusOr<std::string> ReadPicture(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat("no picture ", path));
  std::string bytes(kMaxPictureBytes + 1, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(file.gcount()));
  if (!bytes.empty() && bytes.size() <= kMaxPictureBytes) return bytes;
  return absl::InvalidArgumentError(absl::StrCat(path, ": a picture has 1 to ", kMaxPictureBytes,
                                                 " bytes: write a larger one as JPEG"));
}

v1::LocalizeRequest MakeRequest(const PictureSearch& search, std::string encoded) {
  v1::LocalizeRequest request;
  request.set_mission(MissionName(search.mission));
  ToProto(ExtractFeaturesRequest{.encoded = std::move(encoded), .camera = search.camera},
          request.mutable_picture());
  if (search.near_m.has_value()) {
    // Only the place counts.
    ToProto(Rigid3d{Eigen::Quaterniond::Identity(), -*search.near_m},
            request.mutable_prior()->mutable_camera_from_global());
    request.mutable_prior()->set_radius_m(search.radius_m);
  }
  request.set_all_islands(search.all_islands);
  return request;
}

// What is no picture is the store's to refuse.
absl::Status CheckSize(const PictureSearch& search, const std::string& path,
                       const std::string& encoded) {
  const absl::StatusOr<cv::Size> size = PictureSize(encoded);
  const bool is_known = search.width_px > 0 && search.height_px > 0 && size.ok();
  if (!is_known || *size == cv::Size(search.width_px, search.height_px)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      path, " has ", size->width, "x", size->height, " pixels, and ", search.calibration,
      " is the calibration of pictures of ", search.width_px, "x", search.height_px,
      ": with it the place would be wrong. Give the picture as the camera took it, uncropped, or a "
      "calibration of this size"));
}

// Most cameras look through the middle of their pictures.
std::string DescribeOddCentre(const RawCamera& camera, const std::string& encoded) {
  constexpr double kOdd = 0.15;
  const absl::StatusOr<cv::Size> size = PictureSize(encoded);
  if (!size.ok()) return "";
  const bool is_odd = std::abs(camera.cx_px / size->width - 0.5) > kOdd ||
                      std::abs(camera.cy_px / size->height - 0.5) > kOdd;
  if (!is_odd) return "";
  return absl::StrFormat(
      "the camera's centre, %.1f %.1f, is far from the middle of the picture, which has %dx%d "
      "pixels: are its numbers of this size of picture?",
      camera.cx_px, camera.cy_px, size->width, size->height);
}

// Returns the root of the variances' sum of the place; empty where the points don't tell.
std::string DescribeSigma(const v1::LocalizeResponse& answer) {
  if (answer.covariance_size() != 36) return "";
  const double variance = answer.covariance(0) + answer.covariance(7) + answer.covariance(14);
  return absl::StrFormat(" (sigma %.3f m)", std::sqrt(std::max(variance, 0.0)));
}

absl::StatusOr<Rigid3d> IslandFromCamera(const v1::LocalizeResponse& answer) {
  ASSIGN_OR_RETURN(const Rigid3d camera_from_island, FromProto(answer.camera_from_island()));
  return camera_from_island.Inverse();
}

std::string DescribeOtherCamera(const v1::LocalizeResponse& answer) {
  const v1::Camera& fitting = answer.fitting_camera();
  return absl::StrFormat(
      "%d points of the map agree on a place, but not with this camera: with about fx %.1f fy %.1f "
      "cx %.1f cy %.1f px, or another lens. Is the calibration of this camera, at "
      "this size of picture, uncropped?",
      answer.inliers(), fitting.fx_px(), fitting.fy_px(), fitting.cx_px(), fitting.cy_px());
}

// Says which rule the inliers did not satisfy.
std::string DescribeFewInliers(const v1::LocalizeResponse& answer) {
  const std::string found =
      absl::StrCat("only ", answer.inliers(), " points of the map are where they should be");
  if (answer.inliers_needed() == 0) return found;  // Of an older store.
  return absl::StrCat(found, ", of ", answer.visible_points(), " that should be in the picture; ",
                      answer.inliers_needed(), " are needed where chance alone finds ",
                      answer.chance_inliers());
}

std::string DescribeFailure(const v1::LocalizeResponse& answer) {
  const auto stage = FromProto(answer.stage());
  if (!stage.ok()) return "the store's answer has no stage that is known here";
  switch (*stage) {
    case LocateStage::kFewFeatures:
      return "the picture has too few features: it is dark, blurred or bare";
    case LocateStage::kNoCandidates:
      return "no keyframe of the map looks like it";
    case LocateStage::kFewMatches:
      return absl::StrCat("only ", answer.word_matches(), " features look like the map's");
    case LocateStage::kNoPose:
      return absl::StrCat("of ", answer.word_matches(), " features that look like the map's ",
                          answer.pose_inliers(), " agree on a place");
    case LocateStage::kFewInliers:
      if (answer.has_fitting_camera()) return DescribeOtherCamera(answer);
      return DescribeFewInliers(answer);
    case LocateStage::kCameraInDoubt:
      return absl::StrCat(
          answer.inliers(),
          " points of the map agree on a place, and with another camera it would be "
          "elsewhere: they do not show that this one took the picture. A picture "
          "with near and far things, and to its corners, would");
    case LocateStage::kOutsidePrior:
      return "it was taken outside of the radius";
    case LocateStage::kLocated:
      break;
  }
  return "";
}

}  // namespace

absl::StatusOr<RawCamera> ParseCamera(const std::string& text) {
  ASSIGN_OR_RETURN(const std::vector<double> numbers, ParseNumbers("--camera", text, 4));
  return RawCamera{.fx_px = numbers[0],
                   .fy_px = numbers[1],
                   .cx_px = numbers[2],
                   .cy_px = numbers[3],
                   .lens = {}};
}

absl::StatusOr<Eigen::Vector3d> ParsePlace(const std::string& text) {
  ASSIGN_OR_RETURN(const std::vector<double> numbers, ParseNumbers("--near", text, 3));
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

absl::StatusOr<std::vector<FoundPicture>> FindPictures(
    const std::shared_ptr<grpc::Channel>& channel, const PictureSearch& search) {
  const auto stub = v1::MapStore::NewStub(channel);
  std::vector<FoundPicture> found;
  for (const std::string& path : search.pictures) {
    ASSIGN_OR_RETURN(const std::string encoded, ReadPicture(path));
    RETURN_IF_ERROR(CheckSize(search, path, encoded));
  }
  for (const std::string& path : search.pictures) {
    ASSIGN_OR_RETURN(std::string encoded, ReadPicture(path));
    FoundPicture picture{.path = path,
                         .seconds = 0,
                         .odd_centre = DescribeOddCentre(search.camera, encoded),
                         .answer = {}};
    const v1::LocalizeRequest request = MakeRequest(search, std::move(encoded));
    grpc::ClientContext context;
    SetDeadline(context);
    const absl::Time begin = absl::Now();
    const grpc::Status status = stub->Localize(&context, request, &picture.answer);
    picture.seconds = absl::ToDoubleSeconds(absl::Now() - begin);
    RETURN_IF_ERROR(ToStatus(status, absl::StrCat(path, ": Localize")));
    found.push_back(std::move(picture));
  }
  return found;
}

std::string DescribeFound(const FoundPicture& found) {
  const v1::LocalizeResponse& answer = found.answer;
  if (answer.stage() != v1::LOCATE_STAGE_LOCATED) {
    const std::string why = DescribeFailure(answer);
    if (found.odd_centre.empty()) return absl::StrCat(found.path, ": not found: ", why, "\n");
    return absl::StrCat(found.path, ": not found: ", why, " (", found.odd_centre, ")\n");
  }
  const auto pose = IslandFromCamera(answer);
  if (!pose.ok()) return absl::StrCat(found.path, ": ", pose.status().message(), "\n");
  const Eigen::Vector3d& at = pose->translation;
  const Eigen::Vector3d ahead = pose->rotation * Eigen::Vector3d::UnitZ();
  return absl::StrFormat(
      "%s: at %.3f %.3f %.3f m%s, looks along %.3f %.3f %.3f, %d points agree, %s, %.0f ms\n",
      found.path, at.x(), at.y(), at.z(), DescribeSigma(answer), ahead.x(), ahead.y(), ahead.z(),
      answer.inliers(),
      answer.in_global_frame() ? "global frame"
                               : absl::StrCat("in the frame of island ", answer.island()),
      1e3 * found.seconds);
}

nlohmann::json ToJson(const FoundPicture& found) {
  const v1::LocalizeResponse& answer = found.answer;
  nlohmann::json json = {{"picture", found.path},
                         {"located", answer.stage() == v1::LOCATE_STAGE_LOCATED},
                         {"stage", std::string(absl::StripPrefix(
                                       v1::LocateStage_Name(answer.stage()), "LOCATE_STAGE_"))},
                         {"revision", answer.revision()},
                         {"word_matches", answer.word_matches()},
                         {"pose_inliers", answer.pose_inliers()},
                         {"inliers", answer.inliers()},
                         {"inliers_needed", answer.inliers_needed()},
                         {"visible_points", answer.visible_points()},
                         {"chance_inliers", answer.chance_inliers()},
                         {"seconds", found.seconds}};
  if (answer.has_fitting_camera()) {
    const v1::Camera& fitting = answer.fitting_camera();
    json["fitting_camera"] = {{"fx_px", fitting.fx_px()},
                              {"fy_px", fitting.fy_px()},
                              {"cx_px", fitting.cx_px()},
                              {"cy_px", fitting.cy_px()}};
  }
  const auto pose = IslandFromCamera(answer);
  if (answer.stage() != v1::LOCATE_STAGE_LOCATED || !pose.ok()) return json;
  const Eigen::Vector3d ahead = pose->rotation * Eigen::Vector3d::UnitZ();
  json["position_m"] = {pose->translation.x(), pose->translation.y(), pose->translation.z()};
  json["rotation_wxyz"] = {pose->rotation.w(), pose->rotation.x(), pose->rotation.y(),
                           pose->rotation.z()};
  json["forward"] = {ahead.x(), ahead.y(), ahead.z()};
  json["island"] = answer.island();
  json["in_global_frame"] = answer.in_global_frame();
  json["covariance"] = std::vector<double>(answer.covariance().begin(), answer.covariance().end());
  json["keyframes"] =
      std::vector<std::string>(answer.keyframes().begin(), answer.keyframes().end());
  return json;
}

}  // namespace corbslam::services
