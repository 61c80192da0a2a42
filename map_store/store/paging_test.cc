// Tests lists in pages while items come and go between them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/name_lists.h"
#include "map_store/testing/one_robots_store.h"
#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/two_robots.h"

namespace corbslam::map_store {
namespace {

using testing::Agents;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using testing::Keyframes;
using testing::List;
using testing::Missions;
using testing::NamesOf;
using testing::Overlaps;
using testing::ReadInPages;
using ::testing::SizeIs;
using testing::SyntheticMap;
using testing::TwoRobots;

class MissionPagesTest : public ::testing::Test {
 protected:
  void Make(const std::string& mission, const std::string& agent = "a") {
    SessionRequest request;
    request.mission = mission;
    request.agent = agent;
    const auto opened = store_.OpenSession(request);
    ASSERT_TRUE(opened.ok()) << opened.status();
  }

  MapStore store_{MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr};
};

TEST_F(MissionPagesTest, NoneIsSkippedWhenAnotherIsDeletedBetweenPages) {
  for (const char* name : {"a", "b", "c", "d", "e"}) Make(name);
  const auto first = store_.ListMissions({2, ""});
  ASSERT_TRUE(store_.DeleteMission("a").ok());
  const auto second = store_.ListMissions({2, first->next_page_token});
  EXPECT_THAT(NamesOf(second)->names, ElementsAre("c", "d"));
  // "d" is deleted, which the token names as the last mission of its page.
  ASSERT_TRUE(store_.DeleteMission("d").ok());
  const auto third = store_.ListMissions({2, second->next_page_token});
  EXPECT_THAT(NamesOf(third)->names, ElementsAre("e"));
  EXPECT_EQ(third->next_page_token, "");
}

TEST_F(MissionPagesTest, NoneComesTwiceWhenAnotherIsAddedBetweenPages) {
  for (const char* name : {"b", "d", "f"}) Make(name);
  int added = 0;
  const auto all = ReadInPages(Missions(store_), 1, [&] {
    if (added++ == 0) {
      Make("a");
      Make("e");
    }
  });
  EXPECT_THAT(all, ElementsAre("b", "d", "e", "f")) << "in order; what came behind is there";
}

TEST_F(MissionPagesTest, AgentsComeBetweenPages) {
  for (const char* agent : {"bravo", "delta"}) Make("m", agent);
  int added = 0;
  const auto all = ReadInPages(Agents(store_), 1, [&] {
    if (added++ == 0) {
      Make("m", "alpha");
      Make("m", "charlie");
    }
  });
  EXPECT_THAT(all, ElementsAre("bravo", "charlie", "delta"));
}

TEST_F(MissionPagesTest, AnEmptyListIsOnePage) {
  const auto page = store_.ListMissions({10, ""});
  EXPECT_THAT(page->items, SizeIs(0));
  EXPECT_EQ(page->next_page_token, "");
}

class PagesTest : public TwoRobots {
 protected:
  PagesTest() {
    StreamBoth();
    Fuse();
  }
  std::vector<std::pair<std::string, List>> AllLists() const {
    return testing::AllLists(store_, a_.local_map(), b_.local_map());
  }
};

TEST_F(PagesTest, EverySizeOfPageGivesTheSame) {
  for (const auto& [what, list] : AllLists()) {
    const auto whole = list({0, ""});
    ASSERT_TRUE(whole.ok()) << what << ": " << whole.status();
    EXPECT_FALSE(whole->names.empty()) << what;
    EXPECT_EQ(whole->next_page_token, "") << what;
    for (const size_t size : {1u, 2u, 3u, 7u, 1000u}) {
      EXPECT_THAT(ReadInPages(list, size), ElementsAreArray(whole->names))
          << what << " by " << size;
    }
  }
}

TEST_F(PagesTest, KeyframesThatTheirOwnerRemovesBetweenPages) {
  const auto all = *Keyframes(store_, {})({0, ""});
  const auto first = *Keyframes(store_, {})({3, ""});
  MapUpdateBatch batch = a_.EmptyBatch();
  for (const uint32_t index : {1u, 2u, 3u})
    batch.removed_keyframes.push_back({a_.Id(index), {}, {}});
  ASSERT_TRUE(a_.Send(batch).ok());
  ASSERT_EQ(store_.ListKeyframes("m", {}, {})->items.size(), all.names.size() - 3);
  const auto second = Keyframes(store_, {})({1000, first.next_page_token});
  ASSERT_TRUE(second.ok()) << second.status();
  const std::vector<std::string> rest(all.names.begin() + 4, all.names.end());
  EXPECT_THAT(second->names, ElementsAreArray(rest)) << "the token's own keyframe is gone";
}

TEST_F(PagesTest, OverlapsThatAreFoundAgainBetweenPages) {
  const auto before = *Overlaps(store_)({0, ""});
  ASSERT_GT(before.names.size(), 1u);
  const auto first = *Overlaps(store_)({1, ""});
  ASSERT_TRUE(store_.RederiveGlobalLayer("m").ok());
  Fuse();
  const auto rest = Overlaps(store_)({1000, first.next_page_token});
  ASSERT_TRUE(rest.ok()) << rest.status();
  const auto now = *Overlaps(store_)({0, ""});
  const bool first_is_there = now.names.front() == before.names.front();
  EXPECT_EQ(rest->names.size(), now.names.size() - (first_is_there ? 1 : 0));
}

// One robot's four sessions, of which three are to become one.
class SessionPagesTest : public ::testing::Test {
 protected:
  SessionPagesTest() {
    for (size_t session = 0; session < testing::kStarts; ++session) robot_.Drive(session);
  }
  void Join() { ASSERT_TRUE(robot_.store().RunFusionUntilIdle("m").ok()); }
  void ForgetAllBut(size_t keep) {
    const ForgetRequest request{.agent = testing::kOneRobot, .before_ns = {}, .keep = keep};
    ASSERT_TRUE(robot_.store().ForgetLocalMaps("m", request).ok());
  }
  static std::string Name(uint64_t local_map) { return ToString(LocalMapId{local_map}); }

  testing::OneRobotsStore robot_{true};
};

TEST_F(SessionPagesTest, ListsGoOnBehindSessionsThatBecameOne) {
  const List local_maps = testing::LocalMaps(robot_.store());
  const List keyframes = Keyframes(robot_.store(), {});
  const auto all = *keyframes({0, ""});
  const auto first_maps = *local_maps({2, ""});
  ASSERT_THAT(first_maps.names, ElementsAre(Name(1), Name(2)));
  const auto first = *keyframes({15, ""});
  Join();
  ASSERT_THAT(local_maps({0, ""})->names, ElementsAre(Name(1), Name(4)));
  EXPECT_THAT(local_maps({2, first_maps.next_page_token})->names, ElementsAre(Name(4)));
  const auto rest = *keyframes({1000, first.next_page_token});
  const std::vector<std::string> behind(all.names.begin() + 15, all.names.end());
  EXPECT_THAT(rest.names, ElementsAreArray(behind)) << "none is skipped, and none comes twice";
}

TEST_F(SessionPagesTest, ListsGoOnBehindSessionsThatWereDeleted) {
  Join();
  const List keyframes = Keyframes(robot_.store(), {});
  const auto all = *keyframes({0, ""});
  const auto first_maps = *testing::LocalMaps(robot_.store())({1, ""});
  const auto first = *keyframes({15, ""});
  ForgetAllBut(1);
  EXPECT_THAT(testing::LocalMaps(robot_.store())({1, first_maps.next_page_token})->names,
              ElementsAre(Name(4)));
  const auto rest = *keyframes({1000, first.next_page_token});
  const std::vector<std::string> newest(all.names.end() - testing::kKeyframesOfDrive,
                                        all.names.end());
  EXPECT_THAT(rest.names, ElementsAreArray(newest));
  const auto of_one = Keyframes(robot_.store(), {1})({1, ""});
  EXPECT_TRUE(absl::IsNotFound(of_one.status())) << of_one.status();
}

// A robot whose first session has a greater id than a later one: 9, then 11, then 2.
class PartPagesTest : public ::testing::Test {
 protected:
  // Streams a session and closes it.
  void Drive(const SyntheticMap& made) {
    agents_.push_back(std::make_unique<testing::TestAgent>(store_, "m", testing::kOneRobot, made));
    ASSERT_TRUE(agents_.back()->Stream().ok());
    ASSERT_TRUE(agents_.back()->Close().ok());
  }
  void Join() { ASSERT_TRUE(store_.RunFusionUntilIdle("m").ok()); }
  static MapStoreOptions Options() {
    MapStoreOptions options = testing::OneRobotsStore::Options(true);
    options.keep_local_maps = 0;
    return options;
  }
  static std::vector<std::string> NamesOfAll(const std::vector<const SyntheticMap*>& drives) {
    std::vector<std::string> names;
    for (const SyntheticMap* made : drives) {
      for (const auto& [id, keyframe] : made->map.keyframes()) names.push_back(ToString(id));
    }
    return names;
  }
  static std::vector<std::string> Both(const testing::Names& a, const testing::Names& b) {
    std::vector<std::string> names = a.names;
    names.insert(names.end(), b.names.begin(), b.names.end());
    return names;
  }

  const SyntheticMap first_ = testing::MakeRingMap(9, 1, testing::kKeyframesOfDrive);
  const SyntheticMap greater_ = testing::MakeRingMap(11, 2, testing::kKeyframesOfDrive);
  const SyntheticMap lesser_ = testing::MakeRingMap(2, 3, testing::kKeyframesOfDrive);
  testing::TruthfulWorker worker_{{&first_, &greater_, &lesser_}};
  MapStore store_{Options(), testing::TheWorld().vocabulary, std::make_unique<InMemoryJournal>(),
                  &worker_};
  std::vector<std::unique_ptr<testing::TestAgent>> agents_;
};

TEST_F(PartPagesTest, APartOfALesserIdThatJoinsBetweenPagesIsNotLeftOut) {
  Drive(first_);
  Drive(greater_);
  Join();
  ASSERT_EQ(store_.GetLocalMap("m", {11})->id, LocalMapId{9});
  const List keyframes = Keyframes(store_, {9});
  const auto first = *keyframes({13, ""});
  Drive(lesser_);
  Join();
  ASSERT_EQ(store_.GetLocalMap("m", {2})->id, LocalMapId{9});
  const auto rest = keyframes({1000, first.next_page_token});
  ASSERT_TRUE(rest.ok()) << rest.status();
  EXPECT_THAT(Both(first, *rest), ElementsAreArray(NamesOfAll({&first_, &greater_, &lesser_})));
  for (const size_t size : {1u, 7u, 1000u}) {
    EXPECT_THAT(ReadInPages(keyframes, size), ElementsAreArray(keyframes({0, ""})->names)) << size;
  }
}

// The list is of a local map that becomes a part itself.
TEST_F(PartPagesTest, ALocalMapThatBecomesAPartBetweenPagesIsListedToItsEnd) {
  Drive(first_);
  Drive(greater_);
  const List keyframes = Keyframes(store_, {11});
  const auto first = *keyframes({3, ""});
  Join();
  ASSERT_EQ(store_.GetLocalMap("m", {11})->id, LocalMapId{9});
  const auto rest = keyframes({1000, first.next_page_token});
  ASSERT_TRUE(rest.ok()) << rest.status();
  EXPECT_THAT(Both(first, *rest), ElementsAreArray(NamesOfAll({&greater_, &first_})));
  Drive(lesser_);
  Join();
  const auto later = keyframes({1000, first.next_page_token});
  ASSERT_TRUE(later.ok()) << later.status();
  EXPECT_THAT(Both(first, *later), ElementsAreArray(NamesOfAll({&greater_, &lesser_, &first_})));
}

// When local maps came is written with the state, those that are gone since included.
TEST_F(SessionPagesTest, AfterARestartListsGoOn) {
  const auto first = *testing::LocalMaps(robot_.store())({1, ""});
  const auto keyframes = *Keyframes(robot_.store(), {})({1, ""});
  const auto restarted = [this] {
    auto store = std::make_unique<MapStore>(
        testing::OneRobotsStore::Options(true), testing::TheWorld().vocabulary,
        std::make_unique<testing::ByteJournal>(robot_.bytes()), nullptr);
    EXPECT_TRUE(testing::RecoverUndamaged(*store).ok());
    return store;
  };
  auto store = restarted();
  EXPECT_THAT(testing::LocalMaps(*store)({9, first.next_page_token})->names,
              ElementsAre(Name(2), Name(3), Name(4)));
  Join();
  robot_.bytes()->wants_snapshot = true;
  ForgetAllBut(1);
  Join();
  ASSERT_FALSE(robot_.bytes()->snapshot.empty());
  store = restarted();
  const auto rest = testing::LocalMaps(*store)({9, first.next_page_token});
  ASSERT_TRUE(rest.ok()) << rest.status();
  EXPECT_THAT(rest->names, ElementsAre(Name(4)));
  const auto behind = Keyframes(*store, {})({9, keyframes.next_page_token});
  ASSERT_TRUE(behind.ok()) << behind.status();
  EXPECT_EQ(behind->names, Keyframes(*store, {})({9, ""})->names) << "all before are deleted";
}

}  // namespace
}  // namespace corbslam::map_store
