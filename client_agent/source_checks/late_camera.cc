#include "client_agent/source_checks/late_camera.h"

#include "absl/strings/str_format.h"

namespace corbslam::client_agent {
namespace {

// docs/sources_checks.md says what these limits were derived from.
constexpr double kClearlyBetter = 1.15;
// Least score of a pairing that is to be better: the rows of its matches nearly agree.
constexpr double kLeastScore = 0.5;
constexpr size_t kFewestVotes = 3;
constexpr size_t kVotesAgainstOne = 4;

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

SourceFinding Tell(const char* camera, const char* other_frame, const Votes& votes) {
  return {FindingLevel::kWarning, "pair-late",
          absl::StrFormat("the %s camera is a frame or more behind: right pictures of the frame %s "
                          "agree better with the left ones than those of the same frame in %d of "
                          "%d frames that tell them apart. Pair the pictures by the time at which "
                          "they were taken; is one missing at the start of a folder or list?",
                          camera, other_frame, votes.for_other, votes.for_other + votes.for_own)};
}

}  // namespace

std::optional<SourceFinding> CheckLateCamera(const std::vector<JudgedPair>& pairs) {
  Votes before;
  Votes after;
  for (const JudgedPair& pair : pairs) {
    Vote(pair.evidence, pair.with_before, before);
    Vote(pair.evidence, pair.with_after, after);
  }
  // A right picture that belongs to the frame before shows what the left camera saw earlier.
  if (IsDecided(after)) return Tell("right", "after", after);
  if (IsDecided(before)) return Tell("left", "before", before);
  return std::nullopt;
}

}  // namespace corbslam::client_agent
