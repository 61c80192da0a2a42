#include "client_agent/source_checks/stereo_checks.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

// docs/sources_checks.md says what these limits were derived from.
constexpr double kClearlyBetter = 1.15;
// Least score of a pairing that is to be better: the rows of its matches nearly agree.
constexpr double kLeastScore = 0.5;
constexpr size_t kFewestVotes = 3;
constexpr size_t kVotesAgainstOne = 4;
constexpr double kLeastRelated = 0.06;
constexpr double kLeastInTime = 0.12;
constexpr double kMostNegative = 0.15;
constexpr double kExchangedNegative = 0.8;
constexpr double kMostUnmoved = 0.9;
constexpr double kMostRowError_px = 0.75;
constexpr double kHopelessRowError_px = 4;  // The tracker looks two pixels up and down.
constexpr double kLeastBaseline_m = 0.01;
constexpr double kMostBaseline_m = 5;
constexpr double kSteadyOffset_px = 0.5;
constexpr double kNotableRoll_deg = 0.15;
constexpr size_t kFewestPairs = 3;  // Fewer pairs say nothing about a source.

using Pairs = std::vector<JudgedPair>;

double Share(size_t part, size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

double Related(const PairEvidence& e) { return Share(e.related, e.features); }
double Negative(const PairEvidence& e) { return Share(e.negative, e.negative + e.positive); }
double Unmoved(const PairEvidence& e) { return Share(e.unmoved, e.related); }
double RowError(const PairEvidence& e) { return e.row_error_px; }

double MedianOf(const Pairs& pairs, const std::function<double(const PairEvidence&)>& of) {
  std::vector<double> values;
  for (const JudgedPair& pair : pairs) values.push_back(of(pair.evidence));
  return Median(std::move(values));
}

double MostOf(const Pairs& pairs, const std::function<double(const PairEvidence&)>& of) {
  double most = 0;
  for (const JudgedPair& pair : pairs) most = std::max(most, of(pair.evidence));
  return most;
}

std::string Frames(const Pairs& pairs) {
  return absl::StrCat("median of ", pairs.size(), " frames from ", pairs.front().number, " to ",
                      pairs.back().number);
}

SourceFinding TellUnrelated(const Pairs& pairs) {
  const bool always = pairs.size() >= kFewestPairs && MostOf(pairs, Related) < kLeastRelated;
  return {always ? FindingLevel::kError : FindingLevel::kWarning, "pair-unrelated",
          absl::StrFormat("left and right pictures hardly have anything in common: %.1f %% of "
                          "their features match on rows that agree (%s; a stereo pair has 20 to "
                          "70 %%, less than %.0f %% is none). Are they of one recording and one "
                          "time, and is neither turned or mirrored?",
                          100 * MedianOf(pairs, Related), Frames(pairs), 100 * kLeastRelated)};
}

SourceFinding TellExchanged(const Pairs& pairs, const std::string& evidence) {
  return {FindingLevel::kError, "pair-exchanged",
          absl::StrFormat("left and right are exchanged: %s (%s). Exchange the two folders or "
                          "lists, or the two cameras of the calibration",
                          evidence, Frames(pairs))};
}

SourceFinding TellSigns(const Pairs& pairs) {
  return {FindingLevel::kWarning, "pair-disparity-signs",
          absl::StrFormat("%.0f %% of the matches lie farther right in the right picture than in "
                          "the left one, where nothing can be (%s; more than %.0f %% is not by "
                          "chance). Are the pictures rectified, is cx that of both cameras, and "
                          "were both pictures taken at the same time?",
                          100 * MedianOf(pairs, Negative), Frames(pairs), 100 * kMostNegative)};
}

SourceFinding TellUnmoved(const Pairs& pairs) {
  return {FindingLevel::kWarning, "pair-without-parallax",
          absl::StrFormat("%.0f %% of the matches are at the same pixel in both pictures (%s; more "
                          "than %.0f %% gives no depth). Is the right picture a copy of the left "
                          "one? If all that is seen is far away, a wider baseline is needed",
                          100 * MedianOf(pairs, Unmoved), Frames(pairs), 100 * kMostUnmoved)};
}

SourceFinding TellRows(const Pairs& pairs) {
  const double error = MedianOf(pairs, RowError);
  const double offset = MedianOf(pairs, [](const PairEvidence& e) { return e.fit.offset_px; });
  const double roll_deg = 180 / std::numbers::pi *
                          MedianOf(pairs, [](const PairEvidence& e) { return e.fit.roll_rad; });
  const std::string roll =
      std::abs(roll_deg) < kNotableRoll_deg
          ? ""
          : absl::StrFormat(", and it is turned by %.2f degrees against it", roll_deg);
  return {error > kHopelessRowError_px ? FindingLevel::kError : FindingLevel::kWarning,
          "pair-rows-apart",
          absl::StrFormat("rows of left and right pictures are %.1f px apart: the right one lies "
                          "%.1f px %s in its middle%s (%s; more than %.2f px costs stereo points). "
                          "Rectify the pictures with the calibration of this rig, or give the raw "
                          "pictures with it (layout euroc)",
                          error, std::abs(offset), offset < 0 ? "higher" : "lower", roll,
                          Frames(pairs), kMostRowError_px)};
}

// The same pictures the other way round make a good pair. Rectification by the wrong camera's
// parameters moves rows and columns, so that the signs of disparities say nothing.
bool IsGoodExchanged(const PairPreparation& preparation, const Sample& sample) {
  const Pairs pairs = preparation.Judge(sample, true);
  return !pairs.empty() && MedianOf(pairs, Related) >= kLeastRelated &&
         MedianOf(pairs, RowError) <= kMostRowError_px &&
         MedianOf(pairs, Negative) <= kMostNegative;
}

// Returns whether rows are apart by the same in all frames, as those of a camera that is mounted
// askew are. A late camera's differ with the motion.
bool IsOffsetSteady(const Pairs& pairs) {
  const auto offset_px = [](const PairEvidence& e) { return e.fit.offset_px; };
  const double median_px = MedianOf(pairs, offset_px);
  return MedianOf(pairs, [&](const PairEvidence& e) {
           return std::abs(offset_px(e) - median_px);
         }) < kSteadyOffset_px;
}

struct Votes {
  size_t for_other = 0;
  size_t for_own = 0;
};

void Vote(const PairEvidence& own, const std::optional<PairEvidence>& other, Votes& votes) {
  if (!other.has_value()) return;
  const double least = kLeastScore * static_cast<double>(other->matches);
  if (other->row_score > kClearlyBetter * own.row_score && other->row_score > least) {
    ++votes.for_other;
  } else if (own.row_score > kClearlyBetter * other->row_score) {
    ++votes.for_own;
  }
}

bool IsDecided(const Votes& votes) {
  return votes.for_other >= kFewestVotes && votes.for_other > kVotesAgainstOne * votes.for_own;
}

SourceFinding TellLate(const char* camera, const char* other_frame, const Votes& votes) {
  return {FindingLevel::kWarning, "pair-late",
          absl::StrFormat("the %s camera is a frame or more behind: right pictures of the frame %s "
                          "agree better with the left ones than those of the same frame in %d of "
                          "%d frames that tell them apart. Pair the pictures by the time at which "
                          "they were taken; is one missing at the start of a folder or list?",
                          camera, other_frame, votes.for_other, votes.for_other + votes.for_own)};
}

// Rows agree only between pictures of one time while a camera moves. Returns a finding where the
// right pictures of the frame before (or after) agree better with the left pictures than those of
// the same frame, in nearly all frames that tell the two apart.
std::optional<SourceFinding> CheckLateCamera(const std::vector<JudgedPair>& pairs) {
  Votes before;
  Votes after;
  for (const JudgedPair& pair : pairs) {
    Vote(pair.evidence, pair.with_before, before);
    Vote(pair.evidence, pair.with_after, after);
  }
  // A right picture that belongs to the frame before shows what the left camera saw earlier.
  if (IsDecided(after)) return TellLate("right", "after", after);
  if (IsDecided(before)) return TellLate("left", "before", before);
  return std::nullopt;
}

// Finds what is wrong with the geometry of the pairs: the most telling finding alone, for the
// others follow from it.
void CheckGeometry(const PairPreparation& preparation, const Sample& sample, const Pairs& pairs,
                   SourceFindings& findings) {
  const double negative = MedianOf(pairs, Negative);
  const bool rows_apart = MedianOf(pairs, RowError) > kMostRowError_px;
  if (MedianOf(pairs, Related) < kLeastRelated) {
    // Noise on a bare wall has no counterpart either, and tells nothing about the pair.
    if (preparation.MatchShareInTime(sample) < kLeastInTime) return;
    findings.push_back(TellUnrelated(pairs));
  } else if (std::optional<SourceFinding> late = CheckLateCamera(pairs);
             late.has_value() && !(rows_apart && IsOffsetSteady(pairs))) {
    // This is decided before signs are looked at: while a camera turns, those of a late pair may
    // all be negative.
    findings.push_back(*std::move(late));
  } else if (!preparation.rectifies() && negative > kExchangedNegative) {
    findings.push_back(TellExchanged(
        pairs, absl::StrFormat("%.0f %% of the matches lie farther right in the right picture than "
                               "in the left one",
                               100 * negative)));
  } else if (preparation.rectifies() && (rows_apart || negative > kMostNegative) &&
             IsGoodExchanged(preparation, sample)) {
    findings.push_back(TellExchanged(
        pairs, absl::StrFormat("rectified as they are, rows are %.1f px apart, and exchanged they "
                               "agree",
                               MedianOf(pairs, RowError))));
  } else if (rows_apart) {
    findings.push_back(TellRows(pairs));
  } else if (negative > kMostNegative) {
    findings.push_back(TellSigns(pairs));
  } else if (MedianOf(pairs, Unmoved) > kMostUnmoved) {
    findings.push_back(TellUnmoved(pairs));
  }
}

void CheckBaseline(const Camera& camera, const Pairs& pairs, SourceFindings& findings) {
  const double baseline_m = camera.baseline_m;
  if (baseline_m >= kLeastBaseline_m && baseline_m <= kMostBaseline_m) return;
  std::string depth;
  const double disparity_px =
      pairs.empty() ? 0
                    : MedianOf(pairs, [](const PairEvidence& e) { return e.median_disparity_px; });
  if (disparity_px > 0) {
    depth = absl::StrFormat(": what these pictures show would be %.4g m away (median)",
                            DepthFromDisparity(camera, disparity_px));
  }
  findings.push_back(
      {FindingLevel::kWarning, "baseline-implausible",
       absl::StrFormat("the baseline is %.4g m, outside %.2f to %.0f m%s. Is it in millimetres or "
                       "centimetres? Give it in metres (KITTI's P1 holds -fx times the baseline)",
                       baseline_m, kLeastBaseline_m, kMostBaseline_m, depth)});
}

}  // namespace

StereoJudgement JudgeStereoPair(const StereoCalibration& calibration, const Sample& sample) {
  StereoJudgement judgement;
  const absl::StatusOr<PairPreparation> preparation = PairPreparation::Make(calibration);
  if (!preparation.ok()) {
    judgement.findings.push_back(
        {FindingLevel::kError, "calibration-impossible",
         absl::StrCat("the stereo calibration is impossible: ", preparation.status().message())});
    return judgement;
  }
  judgement.pairs = preparation->Judge(sample);
  const Pairs& pairs = judgement.pairs;
  if (!pairs.empty()) CheckGeometry(*preparation, sample, pairs, judgement.findings);
  CheckBaseline(preparation->camera(), pairs, judgement.findings);
  return judgement;
}

bool MayBeLate(const StereoJudgement& judgement) {
  const bool would_explain =
      std::any_of(judgement.findings.begin(), judgement.findings.end(), [](const auto& finding) {
        return finding.code == "pair-rows-apart" || finding.code == "pair-disparity-signs";
      });
  return would_explain && !(MedianOf(judgement.pairs, RowError) > kMostRowError_px &&
                            IsOffsetSteady(judgement.pairs));
}

}  // namespace corbslam::client_agent
