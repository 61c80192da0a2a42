// Tests what a worker is sent to verify a place: as much as verification looks at, and little more.
#include "map_store/fusion/overlap_query.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"
#include "slam/verification/neighbourhood.h"
#include "slam/verification/place_verification.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

using Ids = std::vector<KeyframeId>;

constexpr char kMission[] = "m";

Ids IdsOf(const std::vector<const Keyframe*>& keyframes) {
  Ids ids;
  for (const Keyframe* keyframe : keyframes) ids.push_back(keyframe->id());
  return ids;
}

// Looks at each request as VerifyPlace would, and at the whole maps beside it.
class InspectingWorker : public TruthfulWorker {
 public:
  explicit InspectingWorker(const std::vector<const SyntheticMap*>& maps)
      : TruthfulWorker(maps), maps_(maps) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    const int neighbours = PlaceVerificationOptions().neighbours;
    for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
      const auto of_query =
          Neighbourhood(*request.query_view, request.query, neighbours, {candidate.id});
      EXPECT_EQ(IdsOf(of_query), IdsOf(Neighbourhood(WholeMap(request.query), request.query,
                                                     neighbours, {candidate.id})));
      absl::btree_set<KeyframeId> except;
      for (const Keyframe* keyframe : of_query) except.insert(keyframe->id());
      const auto of_candidate =
          Neighbourhood(request.candidate_view, candidate.id, neighbours, except);
      EXPECT_EQ(IdsOf(of_candidate),
                IdsOf(Neighbourhood(WholeMap(candidate.id), candidate.id, neighbours, except)));
      Compare(of_query, WholeMap(request.query));
      Compare(of_candidate, WholeMap(candidate.id));
      const auto is_near = [&except](KeyframeId id) { return except.contains(id); };
      touching += std::ranges::any_of(
          IdsOf(Neighbourhood(WholeMap(candidate.id), candidate.id, neighbours)), is_near);
    }
    ++requests;
    most_keyframes = std::max({most_keyframes, request.query_view->keyframes().size(),
                               request.candidate_view.keyframes().size()});
    return TruthfulWorker::VerifyOverlap(request, progress);
  }

  int requests = 0;
  int touching = 0;  // Number of candidates whose neighbourhood shares keyframes with the query's.
  size_t most_keyframes = 0;

 private:
  const Map& WholeMap(KeyframeId id) const {
    return (*std::ranges::find_if(
                maps_,
                [id](const SyntheticMap* map) { return map->map.FindKeyframe(id) != nullptr; }))
        ->map;
  }

  // Expects each keyframe to have all that its owner says it sees.
  static void Compare(const std::vector<const Keyframe*>& keyframes, const Map& whole) {
    for (const Keyframe* keyframe : keyframes) {
      const auto count = [](const Keyframe& of) {
        return std::ranges::count_if(of.points, [](MapPointId id) { return id.IsValid(); });
      };
      EXPECT_EQ(count(*keyframe), count(*whole.FindKeyframe(keyframe->id())));
    }
  }

  const std::vector<const SyntheticMap*> maps_;
};

MapStoreOptions AskEverybody() {
  MapStoreOptions options = DeterministicOptions();
  options.overlap_spacing = 0;
  options.min_shared_landmarks = 100000;
  return options;
}

TEST(VerifyRequestTest, HoldsTheNeighbourhoodsThatVerificationLooksAt) {
  const SyntheticMap map_a = MakeRingMap(0xa, 0, 14);
  const SyntheticMap map_b = MakeRingMap(0xb, 32, 14);
  InspectingWorker worker({&map_a, &map_b});
  worker.refuse_fusing = true;
  MapStoreOptions options = AskEverybody();
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  TestAgent a(store, kMission, "a", map_a);
  TestAgent b(store, kMission, "b", map_b);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  EXPECT_GT(worker.requests, 5);
  const auto most = static_cast<size_t>(1 + PlaceVerificationOptions().neighbours);
  EXPECT_LE(worker.most_keyframes, most * options.max_candidate_groups);
}

// In a loop, what stands in both neighbourhoods counts for the query alone.
TEST(VerifyRequestTest, HoldsThemAlsoWhereTheyTouch) {
  const SyntheticMap map = MakeRingMap(0xa, 0, 20);
  InspectingWorker worker({&map});
  worker.refuse_fusing = true;
  MapStoreOptions options = AskEverybody();
  options.min_loop_gap = 2;
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  TestAgent a(store, kMission, "a", map);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  EXPECT_GT(worker.requests, 5);
  EXPECT_GT(worker.touching, 5);
}

// Two local maps of robots of these names, the second of which begins where the first one ends, in
// a world in which words find nothing. Returns the candidates that a worker is asked about.
Ids CandidatesWithoutWords(const char* first, const char* second) {
  const SyntheticMap map_a = MakeRingMap(0xa, 0, 14);
  const SyntheticMap map_b = MakeRingMap(0xb, 52, 14);
  struct Worker : TruthfulWorker {
    using TruthfulWorker::TruthfulWorker;
    absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                      const ProgressCallback& progress) override {
      EXPECT_LT(request.query.index, 5u);
      for (const auto& candidate : request.candidates) asked.push_back(candidate.id);
      return TruthfulWorker::VerifyOverlap(request, progress);
    }
    Ids asked;
  } worker({&map_a, &map_b});
  MapStoreOptions options = DeterministicOptions();
  options.min_shared_words = 1000000;
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  TestAgent a(store, kMission, first, map_a);
  EXPECT_TRUE(a.Stream().ok());
  EXPECT_TRUE(a.Close().ok());
  TestAgent b(store, kMission, second, map_b);
  EXPECT_TRUE(b.Stream().ok());
  EXPECT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  return worker.asked;
}

TEST(CandidatesTest, ARobotsNextLocalMapIsHeldAgainstWhereItWas) {
  EXPECT_THAT(CandidatesWithoutWords("a", "a"), ::testing::Contains(KeyframeId{{0xa}, 13}));
}

TEST(CandidatesTest, AnotherRobotsIsNot) {
  EXPECT_THAT(CandidatesWithoutWords("a", "b"), ::testing::IsEmpty());
}

}  // namespace
}  // namespace corbslam::map_store
