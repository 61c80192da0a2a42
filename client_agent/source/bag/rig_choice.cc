#include "client_agent/source/bag/rig_choice.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/bag/topic_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMostOthers = 5;
constexpr size_t kMostPictureTopics = 64;
// What speaks for a pair of topics; what comes first decides, whatever comes after it.
constexpr double kScoreCalibrated = 1000;
constexpr double kScoreRegistered = 400;
constexpr double kScoreStereo = 300;
constexpr double kScoreJoined = 200;  // Depth from elsewhere, by a known way.
constexpr double kScoreSameSize = 40;
constexpr double kScorePart = 10;  // For each part that the names have in common.
constexpr double kScoreMessages = 30;
constexpr double kScoreRaw = 8;
constexpr double kScoreGrey = 4;
constexpr double kScoreUnrectified = 2;

struct Candidate {
  RigKind kind = RigKind::kStereo;
  const PictureTopic* first = nullptr;
  const PictureTopic* second = nullptr;
  bool is_registered = false;
  double score = 0;
};

// What all candidates are judged with.
struct Question {
  const std::vector<PictureTopic>& pictures;
  const TransformTree& tree;
  const BagOptions& options;
  bool has_rig = false;
  uint64_t most_messages = 1;
};

bool IsNamed(const PictureTopic& picture, const std::string& name) {
  return picture.name() == name || picture.base == name;
}

bool CanBe(const PictureTopic& picture, const std::string& named) {
  return picture.problem.empty() && (named.empty() || IsNamed(picture, named));
}

bool AreJoined(const TransformTree& tree, const PictureTopic& a, const PictureTopic& b) {
  return !a.frame_id.empty() && a.frame_id != b.frame_id &&
         tree.TargetFromSource(a.frame_id, b.frame_id).has_value();
}

bool HaveSameSize(const PictureTopic& a, const PictureTopic& b) {
  return a.form.size == b.form.size;
}

double ScoreOfBoth(const Question& question, const PictureTopic& a, const PictureTopic& b) {
  const auto fewer = static_cast<double>(std::min(a.topic->messages, b.topic->messages));
  double score = kScoreMessages * fewer / static_cast<double>(question.most_messages);
  score += kScorePart * static_cast<double>(CommonParts(a.base, b.base));
  if (!a.is_compressed && !b.is_compressed) score += kScoreRaw;
  if (absl::StartsWith(a.form.encoding, "mono")) score += kScoreGrey;
  if (!SaysRectified(a.base)) score += kScoreUnrectified;
  return score;
}

bool LookAlike(const PictureTopic& a, const PictureTopic& b) {
  return a.is_compressed == b.is_compressed && a.form.encoding == b.form.encoding &&
         HaveSameSize(a, b);
}

std::optional<Candidate> JudgeStereo(const Question& question, const PictureTopic& left,
                                     const PictureTopic& right) {
  const BagOptions& options = question.options;
  const bool are_named = !options.left.empty() && !options.right.empty();
  if (!left.form.can_be_grey || !right.form.can_be_grey) return std::nullopt;
  if (!are_named && (left.is_depth || right.is_depth || !LookAlike(left, right))) {
    return std::nullopt;
  }
  const std::optional<double> baseline_m = BaselineOfP(left, right);
  const bool by_names = AreLeftAndRight(left.base, right.base);
  const bool by_p = baseline_m.has_value() && *baseline_m > 0;
  if (!are_named && !by_names && !by_p) return std::nullopt;
  Candidate candidate{RigKind::kStereo, &left, &right, false, kScoreStereo};
  candidate.score += ScoreOfBoth(question, left, right);
  if (by_names) candidate.score += kScoreSameSize;
  const bool has_infos = left.info.has_value() && right.info.has_value();
  const bool is_calibrated =
      baseline_m.has_value() || (has_infos && AreJoined(question.tree, left, right));
  if (is_calibrated || question.has_rig) candidate.score += kScoreCalibrated;
  return candidate;
}

bool IsRegistered(const Question& question, const PictureTopic& picture,
                  const PictureTopic& depth) {
  if (question.options.registers.has_value()) return !*question.options.registers;
  if (picture.frame_id == depth.frame_id && !picture.frame_id.empty()) return true;
  return SaysRegistered(depth.base) && !SaysNoDepth(picture.base);
}

std::optional<Candidate> JudgeRgbd(const Question& question, const PictureTopic& picture,
                                   const PictureTopic& depth) {
  const bool is_named = !question.options.depth.empty();
  if (!picture.form.can_be_grey || picture.is_depth) return std::nullopt;
  if (!(is_named ? depth.form.can_be_depth : depth.is_depth)) return std::nullopt;
  Candidate candidate{RigKind::kRgbd, &picture, &depth, IsRegistered(question, picture, depth), 0};
  candidate.score = ScoreOfBoth(question, picture, depth);
  if (HaveSameSize(picture, depth)) candidate.score += kScoreSameSize;
  if (candidate.is_registered) {
    candidate.score += kScoreRegistered;
  } else if (AreJoined(question.tree, picture, depth) && depth.info.has_value()) {
    candidate.score += kScoreJoined;
  }
  if (picture.info.has_value() || question.has_rig) candidate.score += kScoreCalibrated;
  return candidate;
}

std::vector<Candidate> Judge(const Question& question, std::optional<RigKind> kind) {
  const BagOptions& options = question.options;
  std::vector<Candidate> candidates;
  for (const PictureTopic& first : question.pictures) {
    if (!CanBe(first, options.left)) continue;
    for (const PictureTopic& second : question.pictures) {
      if (&first == &second) continue;
      std::optional<Candidate> stereo;
      std::optional<Candidate> rgbd;
      const bool may_be_stereo = options.depth.empty() && CanBe(second, options.right);
      const bool may_be_rgbd = options.right.empty() && CanBe(second, options.depth);
      if (may_be_stereo && kind != RigKind::kRgbd) stereo = JudgeStereo(question, first, second);
      if (may_be_rgbd && kind != RigKind::kStereo) rgbd = JudgeRgbd(question, first, second);
      if (stereo.has_value()) candidates.push_back(*stereo);
      if (rgbd.has_value()) candidates.push_back(*rgbd);
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  return candidates;
}

std::string AsOptions(const Candidate& candidate) {
  return absl::StrCat(
      "left=", candidate.first->name(),
      candidate.kind == RigKind::kStereo ? "&right=" : "&depth=", candidate.second->name());
}

absl::Status CheckNamed(const std::string& bag, const std::vector<PictureTopic>& pictures,
                        absl::string_view option, const std::string& name) {
  if (name.empty()) return absl::OkStatus();
  std::vector<std::string> names;
  for (const PictureTopic& picture : pictures) {
    if (IsNamed(picture, name)) {
      if (picture.problem.empty()) return absl::OkStatus();
      return absl::InvalidArgumentError(
          absl::StrCat(bag, ": ?", option, "=", name, ": ", picture.problem));
    }
    names.push_back(picture.name());
  }
  return absl::NotFoundError(absl::StrCat(
      bag, ": ?", option, "=", name, ": no topic of pictures; ",
      names.empty() ? "it has none" : absl::StrCat("there are ", absl::StrJoin(names, ", "))));
}

absl::Status NoRig(const std::string& bag, const std::vector<PictureTopic>& pictures) {
  if (pictures.empty()) {
    return absl::NotFoundError(
        absl::StrCat(bag,
                     ": no pictures: no topic has sensor_msgs/Image or "
                     "sensor_msgs/CompressedImage ('corbslam bag info' lists what it has)"));
  }
  std::vector<std::string> listed;
  for (const PictureTopic& picture : pictures) listed.push_back(DescribeTopic(picture));
  return absl::NotFoundError(absl::StrCat(
      bag, ": no stereo pair and no RGB-D camera among its pictures: ", absl::StrJoin(listed, ", "),
      ". A single camera is not played; name a pair by ?left=TOPIC&right=TOPIC or "
      "?left=TOPIC&depth=TOPIC"));
}

}  // namespace

std::optional<double> BaselineOfP(const PictureTopic& left, const PictureTopic& right) {
  if (!left.info.has_value() || !right.info.has_value()) return std::nullopt;
  const double fx_px = right.info->p[0];
  const double baseline_m = (left.info->p[3] - right.info->p[3]) / fx_px;
  if (!(fx_px > 0) || !std::isfinite(baseline_m) || baseline_m == 0) return std::nullopt;
  return baseline_m;
}

absl::StatusOr<RigChoice> ChooseRig(const std::string& bag,
                                    const std::vector<PictureTopic>& pictures,
                                    const TransformTree& tree, const BagOptions& options,
                                    std::optional<RigKind> kind) {
  for (const auto& [option, name] :
       {std::pair("left", options.left), {"right", options.right}, {"depth", options.depth}}) {
    RETURN_IF_ERROR(CheckNamed(bag, pictures, option, name));
  }
  if (pictures.size() > kMostPictureTopics &&
      (options.left.empty() || (options.right.empty() && options.depth.empty()))) {
    return absl::InvalidArgumentError(
        absl::StrCat(bag, ": ", pictures.size(),
                     " topics of pictures: name the pair by ?left=TOPIC&right=TOPIC or "
                     "?left=TOPIC&depth=TOPIC"));
  }
  Question question{pictures, tree, options, kind.has_value(), 1};
  for (const PictureTopic& picture : pictures) {
    question.most_messages = std::max(question.most_messages, picture.topic->messages);
  }
  const std::vector<Candidate> candidates = Judge(question, kind);
  if (candidates.empty()) return NoRig(bag, pictures);
  const Candidate& best = candidates.front();
  RigChoice choice{best.kind, *best.first, *best.second, best.is_registered, {}};
  for (size_t i = 1; i < candidates.size() && choice.others.size() < kMostOthers; ++i) {
    choice.others.push_back(AsOptions(candidates[i]));
  }
  return choice;
}

}  // namespace corbslam::client_agent
