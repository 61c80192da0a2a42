#include "slam/optimisation/robust_edges.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/optimisation/graduated_non_convexity.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// A switched-off edge still holds the graph together.
constexpr double kLeastWeight = 1e-9;
constexpr int kMaxRounds = 100;
// Each chance takes about as many solves as the first decision.
constexpr int kMaxChances = 60;
// A chance must lead to a cost that is lower by this share.
constexpr double kCheaper = 1e-6;

// How a loser is supposed to be right.
struct Supposition {
  double weight = 1;            // Weight of the loser, which is never truncated.
  bool all_have_a_say = false;  // True: all others have a say again; false: only those that won.
};
// Each way finds what the others don't, where several wrong clusters support each other.
constexpr Supposition kSuppositions[] = {{1, false}, {1, true}, {100, false}};

class Decision {
 public:
  explicit Decision(PoseGraphProblem& problem) : problem_(problem) {}

  absl::Status Decide() {
    RETURN_IF_ERROR(Solve());
    if (!HasLosers()) return absl::OkStatus();
    RETURN_IF_ERROR(Graduate());
    return HasLosers() ? GiveSecondChances() : absl::OkStatus();
  }

 private:
  struct State {
    PoseGraphProblem::Blocks poses;
    std::vector<double> weights;  // Weights of the robust edges, in their order.
    std::vector<double> chi2;
    double cost = 0;
  };

  bool IsLoser(size_t edge) const { return chi2_[edge] > problem_.max_chi2(); }
  bool HasLosers() const {
    return std::any_of(problem_.robust().begin(), problem_.robust().end(),
                       [this](size_t edge) { return IsLoser(edge); });
  }

  absl::Status Solve() {
    RETURN_IF_ERROR(problem_.Solve());
    chi2_ = problem_.EdgeChi2();
    return absl::OkStatus();
  }

  // Returns the worst chi2 of the robust edges that have a say and are not supposed to be right.
  double WorstChi2() const {
    double worst = 0;
    for (const size_t edge : problem_.robust()) {
      if (edge != supposed_ && problem_.weight(edge) > kLeastWeight) {
        worst = std::max(worst, chi2_[edge]);
      }
    }
    return worst;
  }

  bool UpdateWeights(const GraduatedTruncation& truncation) {
    bool changed = false;
    for (const size_t edge : problem_.robust()) {
      if (edge == supposed_) continue;
      changed |= problem_.SetWeight(edge, std::max(kLeastWeight, truncation.Weight(chi2_[edge])));
    }
    return changed;
  }

  // Weighs and solves in turn while the truncation sharpens, from the last solution on.
  absl::Status Graduate() {
    const double worst = std::max(WorstChi2(), problem_.max_chi2() * (1 + 1e-9));
    GraduatedTruncation truncation(problem_.max_chi2(), worst);
    for (int round = 0; round < kMaxRounds; ++round) {
      // Weights between 0 and 1 change with the truncation: those that don't are all decided.
      if (!UpdateWeights(truncation)) break;
      RETURN_IF_ERROR(Solve());
      truncation.Sharpen();
    }
    return absl::OkStatus();
  }

  // Computes what comes of it if a loser is right: the others are decided under it, then it as any
  // other.
  absl::Status Suppose(size_t loser, const Supposition& supposition) {
    supposed_ = loser;
    if (supposition.all_have_a_say) {
      for (const size_t edge : problem_.robust()) problem_.SetWeight(edge, 1);
    }
    problem_.SetWeight(loser, supposition.weight);
    RETURN_IF_ERROR(Solve());
    RETURN_IF_ERROR(Graduate());
    supposed_.reset();
    if (problem_.SetWeight(loser, 1)) RETURN_IF_ERROR(Solve());
    return Graduate();
  }

  State Save() const {
    State state{problem_.poses(), {}, chi2_, problem_.TruncatedCost(chi2_)};
    for (const size_t edge : problem_.robust()) state.weights.push_back(problem_.weight(edge));
    return state;
  }
  void Restore(const State& state) {
    problem_.SetPoses(state.poses);
    for (size_t i = 0; i < state.weights.size(); ++i) {
      problem_.SetWeight(problem_.robust()[i], state.weights[i]);
    }
    chi2_ = state.chi2;
  }

  // Returns the loser that disagrees least.
  std::optional<size_t> NextLoser(const std::set<size_t>& heard) const {
    std::optional<size_t> next;
    for (const size_t edge : problem_.robust()) {
      if (!IsLoser(edge) || heard.contains(edge)) continue;
      if (!next.has_value() || chi2_[edge] < chi2_[*next]) next = edge;
    }
    return next;
  }

  // Returns true if what the chance led to costs less than `best`, which is replaced then.
  absl::StatusOr<bool> GiveChance(size_t loser, const Supposition& supposition, State& best) {
    if (!Suppose(loser, supposition).ok()) {
      // Weights of such a spread can't always be solved: then there is nothing in it.
      supposed_.reset();
      return false;
    }
    State supposed = Save();
    if (supposed.cost >= (1 - kCheaper) * best.cost) return false;
    best = std::move(supposed);
    return true;
  }

  // Returns true as soon as one way of supposing found something cheaper than `best`.
  absl::StatusOr<bool> GiveChances(const Supposition& supposition, State& best) {
    std::set<size_t> heard;
    bool is_cheaper = false;
    while (!is_cheaper && chances_left_ > 0) {
      const std::optional<size_t> loser = NextLoser(heard);
      if (!loser.has_value()) break;
      --chances_left_;
      ASSIGN_OR_RETURN(is_cheaper, GiveChance(*loser, supposition, best));
      // Supposing an edge that agrees with it would lead to the same.
      heard.insert(*loser);
      for (const size_t edge : problem_.robust()) {
        if (!IsLoser(edge)) heard.insert(edge);
      }
      Restore(best);
    }
    return is_cheaper;
  }

  absl::Status GiveSecondChances() {
    State best = Save();
    const auto* supposition = std::begin(kSuppositions);
    while (supposition != std::end(kSuppositions)) {
      ASSIGN_OR_RETURN(const bool is_cheaper, GiveChances(*supposition, best));
      supposition = is_cheaper ? std::begin(kSuppositions) : supposition + 1;
    }
    return absl::OkStatus();
  }

  PoseGraphProblem& problem_;
  std::vector<double> chi2_;  // Chi2 of all edges after the last solve.
  std::optional<size_t> supposed_;
  int chances_left_ = kMaxChances;
};

}  // namespace

absl::Status SolveRobustly(PoseGraphProblem& problem) { return Decision(problem).Decide(); }

}  // namespace corbslam
