#include "client_agent/source_checks/picture_checks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

using Histogram = std::array<uint32_t, 256>;

// The smallest grey level up to which more than `share` of the pixels lie.
int Rank(const Histogram& histogram, uint32_t pixels, double share) {
  double below = 0;
  for (size_t grey = 0; grey < histogram.size(); ++grey) {
    below += histogram[grey];
    if (below > share * pixels) return static_cast<int>(grey);
  }
  return 255;
}

// docs/sources_checks.md says what these limits were derived from.
constexpr int kBlack = 24;
constexpr int kLeastContrast = 16;
constexpr double kMostWhite = 0.6;
constexpr size_t kFewestFrames = 3;  // Fewer frames say nothing about a source.

// One camera's pictures, those of the right size.
struct CameraPictures {
  std::string name;
  std::vector<size_t> numbers;
  std::vector<cv::Mat> pictures;
  std::vector<PictureStatistics> statistics;

  bool AreConstant() const {
    return std::all_of(statistics.begin(), statistics.end(),
                       [](const PictureStatistics& s) { return s.IsConstant(); });
  }
};

cv::Size SizeOf(const SensorCalibration& calibration) {
  const Camera first = FirstCameraOf(calibration).camera;
  return {first.width_px, first.height_px};
}

SourceFinding TellSize(const CameraPictures& camera, size_t number, const cv::Size& given,
                       const cv::Size& expected) {
  return {FindingLevel::kError, "picture-size",
          absl::StrFormat("frame %d: the %s picture is %dx%d, the calibration is that of %dx%d: "
                          "give the calibration of these pictures, or the pictures as they were "
                          "calibrated",
                          number, camera.name, given.width, given.height, expected.width,
                          expected.height)};
}

// Adds what can be judged to `camera`, and a finding for the first picture of another size.
void AddPictures(const cv::Size& size, const Sample& sample,
                 const std::function<const cv::Mat&(const SensorImages&)>& picture_of,
                 CameraPictures& camera, SourceFindings& findings) {
  bool told = false;
  for (const SampleFrame& frame : sample) {
    const cv::Mat& picture = picture_of(frame.images);
    if (picture.size() == size && picture.type() == CV_8UC1) {
      camera.numbers.push_back(frame.number);
      camera.pictures.push_back(picture);
      camera.statistics.push_back(MeasurePicture(picture));
    } else if (!told) {
      findings.push_back(TellSize(camera, frame.number, picture.size(), size));
      told = true;
    }
  }
}

// Returns "in 11 of 12 frames of the sample".
std::string InFrames(size_t count, const CameraPictures& camera) {
  return absl::StrCat("in ", count, " of ", camera.pictures.size(), " frames of the sample");
}

int Bright(const PictureStatistics& s) { return s.bright; }
int Contrast(const PictureStatistics& s) { return s.Contrast(); }

int MedianOf(const CameraPictures& camera, int (*of)(const PictureStatistics&)) {
  std::vector<int> values;
  for (const PictureStatistics& statistics : camera.statistics) values.push_back(of(statistics));
  return Median(std::move(values));
}

// Returns how many pictures are so; 0 unless they are more than half of all.
size_t CountMost(const CameraPictures& camera,
                 const std::function<bool(const PictureStatistics&)>& is_so) {
  const auto count =
      static_cast<size_t>(std::count_if(camera.statistics.begin(), camera.statistics.end(), is_so));
  return 2 * count > camera.statistics.size() ? count : 0;
}

SourceFinding TellConstant(const CameraPictures& camera, size_t count) {
  const bool always = count == camera.pictures.size();
  return {always ? FindingLevel::kError : FindingLevel::kWarning, "pictures-constant",
          absl::StrFormat("%s pictures have one grey level, %d, all over %s: there is nothing to "
                          "see. Look at the files, and at the camera",
                          camera.name, MedianOf(camera, Bright), InFrames(count, camera))};
}

SourceFinding TellBlack(const CameraPictures& camera, size_t count) {
  return {
      FindingLevel::kWarning, "pictures-nearly-black",
      absl::StrFormat("%s pictures are nearly black %s: 99 %% of their pixels are below %d of "
                      "255 (median over the frames; less than %d is nearly black). Are they "
                      "of another bit depth, or under-exposed? Scale their grey levels",
                      camera.name, InFrames(count, camera), MedianOf(camera, Bright) + 1, kBlack)};
}

SourceFinding TellWhite(const CameraPictures& camera, size_t count) {
  return {FindingLevel::kWarning, "pictures-overexposed",
          absl::StrFormat("%s pictures are overexposed %s: more than %.0f %% of their pixels are "
                          "at 255. Shorten the exposure, or scale pictures of more bits down "
                          "before they are cut to 8",
                          camera.name, InFrames(count, camera), 100 * kMostWhite)};
}

SourceFinding TellFlat(const CameraPictures& camera, size_t count) {
  return {FindingLevel::kWarning, "pictures-without-contrast",
          absl::StrFormat("%s pictures have hardly any contrast %s: 98 %% of their pixels lie "
                          "within %d grey levels (median over the frames; less than %d is too "
                          "little). Is the lens covered, or out of focus?",
                          camera.name, InFrames(count, camera), MedianOf(camera, Contrast),
                          kLeastContrast)};
}

// The first of these findings that holds for most pictures says enough.
void CheckLight(const CameraPictures& camera, SourceFindings& findings) {
  struct Kind {
    bool (*is_so)(const PictureStatistics&);
    SourceFinding (*tell)(const CameraPictures&, size_t);
  };
  const Kind kinds[] = {
      {[](const PictureStatistics& s) { return s.IsConstant(); }, TellConstant},
      {[](const PictureStatistics& s) { return s.bright < kBlack; }, TellBlack},
      {[](const PictureStatistics& s) { return s.white_share > kMostWhite; }, TellWhite},
      {[](const PictureStatistics& s) { return s.Contrast() < kLeastContrast; }, TellFlat}};
  for (const Kind& kind : kinds) {
    const size_t count = CountMost(camera, kind.is_so);
    if (count == 0) continue;
    findings.push_back(kind.tell(camera, count));
    return;
  }
}

// Returns whether all pictures of a camera are the same one.
bool IsStuck(const CameraPictures& camera) {
  if (camera.pictures.size() < kFewestFrames || camera.AreConstant()) return false;
  return std::all_of(
      camera.pictures.begin() + 1, camera.pictures.end(),
      [&](const cv::Mat& picture) { return AreSame(picture, camera.pictures.front()); });
}

void CheckStuck(const std::vector<CameraPictures>& cameras, SourceFindings& findings) {
  const auto stuck = static_cast<size_t>(std::count_if(cameras.begin(), cameras.end(), IsStuck));
  for (const CameraPictures& camera : cameras) {
    if (!IsStuck(camera)) continue;
    const bool other_moves = stuck < cameras.size();
    findings.push_back(
        {other_moves ? FindingLevel::kError : FindingLevel::kWarning, "camera-stuck",
         absl::StrFormat("the %s picture is the same to the byte in all %d frames of the sample, "
                         "%d to %d%s: a camera's noise makes every picture another. Was one "
                         "picture written again and again?",
                         camera.name, camera.pictures.size(), camera.numbers.front(),
                         camera.numbers.back(),
                         other_moves ? ", though the other camera's change" : "")});
  }
}

// Returns whether a picture shows so much that no other camera's is the same to the byte: two in
// the dark, or of two covered lenses, may be.
bool ShowsSomething(const cv::Mat& picture) {
  if (picture.type() != CV_8UC1) return true;
  const PictureStatistics statistics = MeasurePicture(picture);
  return statistics.bright >= kBlack && statistics.Contrast() >= kLeastContrast;
}

// Finds frames in whose pair both pictures are the same to the byte.
void CheckSamePicture(const Sample& sample, SourceFindings& findings) {
  std::vector<size_t> same;
  size_t judged = 0;
  for (const SampleFrame& frame : sample) {
    const SensorImages& images = frame.images;
    if (images.grey.empty() || images.right.empty()) continue;
    if (!ShowsSomething(images.grey)) continue;
    ++judged;
    if (AreSame(images.grey, images.right)) same.push_back(frame.number);
  }
  if (same.empty()) return;
  findings.push_back(
      {2 * same.size() > judged ? FindingLevel::kError : FindingLevel::kWarning,
       "pair-same-picture",
       absl::StrFormat("left and right pictures are the same to the byte in %d of %d frames of the "
                       "sample, in frame %d first: no depth can be had of them. Does the right "
                       "camera's list or folder name the left one's files?",
                       same.size(), judged, same.front())});
}

}  // namespace

PictureStatistics MeasurePicture(const cv::Mat& grey) {
  Histogram histogram = {};
  uint32_t pixels = 0;
  for (int y = 0; y < grey.rows; y += 2) {
    const auto* row = grey.ptr<uint8_t>(y);
    for (int x = 0; x < grey.cols; x += 2, ++pixels) ++histogram[row[x]];
  }
  PictureStatistics statistics;
  statistics.least = Rank(histogram, pixels, 0);
  statistics.dark = Rank(histogram, pixels, 0.01);
  statistics.median = Rank(histogram, pixels, 0.5);
  statistics.bright = Rank(histogram, pixels, 0.99);
  statistics.most = 255;
  while (statistics.most > 0 && histogram[static_cast<size_t>(statistics.most)] == 0) {
    --statistics.most;
  }
  statistics.white_share = static_cast<double>(histogram[255]) / pixels;
  return statistics;
}

bool AreSame(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  const size_t bytes = static_cast<size_t>(a.cols) * a.elemSize();
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), bytes) != 0) return false;
  }
  return true;
}

SourceFindings CheckPictures(const SensorCalibration& calibration, const Sample& sample) {
  const cv::Size size = SizeOf(calibration);
  const bool is_stereo = KindOf(calibration) == SensorKind::kStereo;
  SourceFindings findings;
  std::vector<CameraPictures> cameras(is_stereo ? 2 : 1);
  cameras[0].name = is_stereo ? "left" : "grey";
  AddPictures(
      size, sample, [](const SensorImages& i) -> const cv::Mat& { return i.grey; }, cameras[0],
      findings);
  if (is_stereo) {
    cameras[1].name = "right";
    AddPictures(
        size, sample, [](const SensorImages& i) -> const cv::Mat& { return i.right; }, cameras[1],
        findings);
    CheckSamePicture(sample, findings);
  }
  for (const CameraPictures& camera : cameras) {
    if (!camera.pictures.empty()) CheckLight(camera, findings);
  }
  CheckStuck(cameras, findings);
  return findings;
}

}  // namespace corbslam::client_agent
