// Tests that several stores share the missions of one database: each mission has one owner, robots
// are told where it is, and what was acknowledged is there whoever has it next.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/mission/mission_load.h"
#include "map_store/postgres/fleet_directory.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/postgres/sql_pool.h"
#include "map_store/records/mission_leases.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/cutting_proxy.h"
#include "map_store/testing/postgres_server.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/exchange/session_end.h"

namespace corbslam::map_store {
namespace {

using ::testing::AllOf;
using testing::CuttingProxy;
using testing::DeterministicOptions;
using testing::DumpLocal;
using ::testing::HasSubstr;
using testing::MakeRingMap;
using testing::PostgresServer;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;

constexpr char kShared[] = "m";

class SharedMissionsTest : public ::testing::Test {
 protected:
  // Starts the store that others reach at `address`.
  std::unique_ptr<MapStore> Start(const std::string& address,
                                  absl::Duration lease = absl::Seconds(3), std::string uri = "") {
    if (uri.empty()) uri = server_.Uri(database_);
    auto journal = PostgresJournal::Open({.uri = uri, .lease = lease, .holder_name = address});
    EXPECT_TRUE(journal.ok()) << journal.status();
    MapStoreOptions options = DeterministicOptions();
    options.sleep_after_s = 600;
    auto store =
        std::make_unique<MapStore>(options, TheWorld().vocabulary, *std::move(journal), nullptr);
    EXPECT_TRUE(store->Recover().ok());
    DirectoryStore self;
    self.name = self.address = address;
    EXPECT_TRUE(store->leases()->Announce(self).ok());
    return store;
  }
  // Has all leases end, as if their stores had not been heard of since, and enters the store. The
  // other one may just say that it lives.
  absl::StatusOr<MapStore::OpenedSession> EnterOnceLeasesEnd(MapStore& store,
                                                             const std::string& uid = "") const {
    absl::StatusOr<MapStore::OpenedSession> entered = absl::UnknownError("not asked");
    for (int i = 0; i < 20 && !entered.ok(); ++i) {
      server_.Ask(database_, "UPDATE corbslam.missions SET lease_until = clock_timestamp()");
      entered = Enter(store, kShared, uid);
    }
    return entered;
  }
  static absl::StatusOr<MapStore::OpenedSession> Enter(MapStore& store,
                                                       const std::string& mission = kShared,
                                                       const std::string& uid = "") {
    SessionRequest request{mission, "robot", 0, {{0xa}}};
    request.mission_uid = uid;
    return store.OpenSession(request);
  }
  static std::string Where(const absl::Status& status) {
    const auto elsewhere = FindElsewhere(status);
    return elsewhere.has_value() ? elsewhere->address : "it does not say";
  }
  std::string Epoch() const {
    return server_.Ask(database_, "SELECT epoch FROM corbslam.missions");
  }

  PostgresServer& server_ = PostgresServer::Get();
  const std::string database_ = server_.MakeDatabase();
  const SyntheticMap map_ = MakeRingMap(0xa, 0, 14);
};

TEST_F(SharedMissionsTest, AStoreHasWhatItIsAskedForFirstAndSaysWhereTheRestIs) {
  const auto a = Start("a:1");
  const auto b = Start("b:2");
  ASSERT_TRUE(Enter(*a, "at_a").ok());
  ASSERT_TRUE(Enter(*b, "at_b").ok());
  const absl::Status elsewhere = Enter(*b, "at_a").status();
  EXPECT_TRUE(absl::IsUnavailable(elsewhere)) << elsewhere;
  EXPECT_EQ(Where(elsewhere), "a:1");
  EXPECT_THAT(std::string(elsewhere.message()), HasSubstr("mission at_a is at a:1"));
  EXPECT_EQ(Where(b->GetMission("at_a").status()), "a:1");
  EXPECT_EQ(Where(b->ListAgents("at_a", {}).status()), "a:1");
  EXPECT_EQ(Where(a->DeleteMission("at_b")), "b:2");
  EXPECT_EQ(Where(a->SleepMission("at_b")), "b:2");
  EXPECT_TRUE(absl::IsAlreadyExists(a->CreateMission("at_b", {})));
  EXPECT_TRUE(absl::IsNotFound(a->GetMission("nowhere").status()));
  // Both list both.
  for (MapStore* store : {a.get(), b.get()}) {
    const auto listed = store->ListMissions({});
    ASSERT_TRUE(listed.ok()) << listed.status();
    ASSERT_EQ(listed->items.size(), 2);
    EXPECT_EQ(listed->items[0].name, "at_a");
    EXPECT_EQ(listed->items[1].name, "at_b");
  }
  EXPECT_TRUE(a->GetMission("at_a").ok());
}

TEST_F(SharedMissionsTest, WhatWasAcknowledgedIsThereOnceAnotherStoreHasTakenOver) {
  const auto a = Start("a:1");
  const auto b = Start("b:2");
  TestAgent robot(*a, kShared, "robot", map_);
  ASSERT_TRUE(robot.Stream(7).ok());
  const std::string before = DumpLocal(kShared, *a);
  const std::string uid = a->GetMission(kShared)->uid;
  // Its robot comes to the other store, with all that it was told.
  const auto entered = EnterOnceLeasesEnd(*b, uid);
  ASSERT_TRUE(entered.ok()) << entered.status();
  ASSERT_EQ(entered->grant.acknowledged.size(), 1);
  EXPECT_EQ(entered->grant.acknowledged[0].number, 7);
  EXPECT_EQ(DumpLocal(kShared, *b), before);
  // The one that has lost it acknowledges nothing more, and says so at once.
  const MapUpdateBatch next = robot.NextBatch(1);
  const absl::Status lost = robot.Send(next);
  EXPECT_FALSE(lost.ok());
  EXPECT_FALSE(SaysMissionDeleted(lost)) << lost;
  EXPECT_EQ(Where(lost), "b:2") << lost;
  a->KeepLeases();
  const absl::Status told = a->NextShared(robot.session(), 1 << 20).status();
  EXPECT_EQ(Where(told), "b:2") << told;
  EXPECT_EQ(Where(robot.Send(next)), "b:2");
  EXPECT_EQ(Where(Enter(*a, kShared, uid).status()), "b:2");
  EXPECT_TRUE(a->ListLoads().empty());
  // The robot goes on with the other one.
  ASSERT_TRUE(b->Apply(entered->session_id, next).ok());
  EXPECT_EQ(Epoch(), "2");
}

TEST_F(SharedMissionsTest, AStoreThatWasSilentLearnsOfItsLossByItself) {
  const auto a = Start("a:1");
  const auto b = Start("b:2");
  const auto robot = Enter(*a);
  ASSERT_TRUE(robot.ok()) << robot.status();
  ASSERT_TRUE(EnterOnceLeasesEnd(*b).ok());
  // Nobody writes. It says that it lives, and hears that it has the mission no more.
  absl::Status told;
  for (int i = 0; i < 50 && told.ok(); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    a->KeepLeases();
    told = a->NextShared(robot->session_id, 1 << 20).status();
  }
  EXPECT_EQ(Where(told), "b:2") << told;
  EXPECT_TRUE(a->ListLoads().empty());
}

TEST_F(SharedMissionsTest, AMissionThatSleepsIsWhoseIsAskedNext) {
  const auto a = Start("a:1", absl::Hours(1));
  const auto b = Start("b:2", absl::Hours(1));
  {
    TestAgent robot(*a, kShared, "robot", map_);
    ASSERT_TRUE(robot.Stream().ok());
    ASSERT_TRUE(robot.Close().ok());
    a->CloseSession(robot.session());
  }
  const std::string before = DumpLocal(kShared, *a);
  ASSERT_TRUE(a->SleepMission(kShared).ok());
  for (MapStore* store : {a.get(), b.get()}) {
    const auto info = store->GetMission(kShared);
    ASSERT_TRUE(info.ok()) << info.status();
    EXPECT_TRUE(info->asleep);
    EXPECT_EQ(info->agents, 1);
    EXPECT_TRUE(store->SleepMission(kShared).ok());
  }
  ASSERT_TRUE(Enter(*b).ok());
  EXPECT_EQ(DumpLocal(kShared, *b), before);
  EXPECT_EQ(Where(Enter(*a).status()), "b:2");
}

TEST_F(SharedMissionsTest, AStoreThatEndsGivesBackAllThatItHas) {
  auto a = Start("a:1", absl::Hours(1));
  const auto b = Start("b:2", absl::Hours(1));
  const auto robot = Enter(*a);
  ASSERT_TRUE(robot.ok());
  const std::string uid = robot->grant.mission_uid;
  EXPECT_EQ(Where(Enter(*b).status()), "a:1");
  a.reset();
  const auto again = Enter(*b, kShared, uid);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->grant.mission_uid, uid);
}

TEST_F(SharedMissionsTest, AStoreThatComesBackHasItsMissionsAtOnceAndItsForerunnerNone) {
  const auto killed = Start("a:1", absl::Hours(1));
  ASSERT_TRUE(Enter(*killed).ok());
  const auto b = Start("b:2", absl::Hours(1));
  ASSERT_TRUE(Enter(*b, "other").ok());
  const auto again = Start("a:1", absl::Hours(1));
  EXPECT_EQ(Where(Enter(*again, "other").status()), "b:2");
  ASSERT_TRUE(Enter(*again).ok());
  ASSERT_TRUE(Enter(*again, "one_more").ok());
  EXPECT_EQ(Where(Enter(*b).status()), "a:1");
}

TEST_F(SharedMissionsTest, TwoProcessesOfOneNameDoNotThrowEachOtherOut) {
  const auto first = Start("a:1");
  const auto robot = Enter(*first);
  ASSERT_TRUE(robot.ok());
  const auto second = Start("a:1");
  absl::Status refused;
  for (int i = 0; i < 50 && refused.ok(); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    first->KeepLeases();
    refused = Enter(*first, absl::StrCat("new_", i)).status();
  }
  EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("another process has begun as store a:1"));
  first->KeepLeases();
  EXPECT_FALSE(first->NextShared(robot->session_id, 1 << 20).ok());
  ASSERT_TRUE(Enter(*second).ok());
}

TEST_F(SharedMissionsTest, OfTwoThatMakeAMissionAtOnceOneHasIt) {
  std::vector<std::unique_ptr<MapStore>> stores;
  for (int i = 0; i < 3; ++i) stores.push_back(Start(absl::StrCat("s", i, ":1")));
  for (int round = 0; round < 10; ++round) {
    const std::string mission = absl::StrCat("made_", round);
    std::vector<absl::StatusOr<MapStore::OpenedSession>> entered(stores.size(),
                                                                 absl::UnknownError("not asked"));
    std::vector<std::thread> threads;
    for (size_t i = 0; i < stores.size(); ++i) {
      threads.emplace_back([&, i] { entered[i] = Enter(*stores[i], mission); });
    }
    for (std::thread& thread : threads) thread.join();
    int owners = 0;
    for (size_t i = 0; i < stores.size(); ++i) {
      owners += entered[i].ok();
      if (!entered[i].ok()) {
        EXPECT_TRUE(absl::IsUnavailable(entered[i].status())) << entered[i].status();
      }
    }
    EXPECT_EQ(owners, 1);
  }
  EXPECT_EQ(server_.Ask(database_, "SELECT count(*) FROM corbslam.missions"), "10");
}

TEST_F(SharedMissionsTest, WhatOneStoreHasDeletedNoOtherOneMakesAnew) {
  const auto a = Start("a:1");
  const auto b = Start("b:2");
  const auto robot = Enter(*a);
  ASSERT_TRUE(robot.ok());
  const std::string uid = robot->grant.mission_uid;
  // The one that has none of it can't; the one that has it can, and so can another one later.
  EXPECT_FALSE(b->DeleteMission(kShared).ok());
  ASSERT_TRUE(a->DeleteMission(kShared).ok());
  const absl::Status over = Enter(*b, kShared, uid).status();
  EXPECT_TRUE(SaysMissionDeleted(over)) << over;
  const auto anew = Enter(*b);
  ASSERT_TRUE(anew.ok()) << anew.status();
  EXPECT_NE(anew->grant.mission_uid, uid);
  EXPECT_EQ(Where(Enter(*a).status()), "b:2");
}

TEST_F(SharedMissionsTest, AStoreThatIsCutOffRefusesRobotsAndGoesOnWhereNobodyTookOver) {
  auto proxy = std::make_unique<CuttingProxy>(server_.port());
  const int port = proxy->port();
  const auto a = Start("a:1", absl::Seconds(3), server_.TcpUri(database_, port));
  TestAgent robot(*a, kShared, "robot", map_);
  ASSERT_TRUE(robot.Stream(3).ok());
  proxy->CutAt("UPDATE", CuttingProxy::Moment::kBefore, 1'000'000);
  absl::Status told;
  for (int i = 0; i < 100 && told.ok(); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    a->KeepLeases();
    told = a->NextShared(robot.session(), 1 << 20).status();
  }
  EXPECT_TRUE(absl::IsUnavailable(told)) << told;
  EXPECT_THAT(std::string(told.message()), HasSubstr("was not reached for the 3s of a lease"));
  EXPECT_TRUE(absl::IsUnavailable(Enter(*a, "new").status()));
  proxy->CutAt("UPDATE", CuttingProxy::Moment::kNever, 0);
  absl::StatusOr<MapStore::OpenedSession> again = absl::UnknownError("not asked");
  for (int i = 0; i < 100 && !again.ok(); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    a->KeepLeases();
    again = Enter(*a);
  }
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->grant.acknowledged[0].number, 3);
  EXPECT_TRUE(a->Apply(again->session_id, robot.NextBatch(1)).ok());
  // It never read the mission again.
  EXPECT_EQ(Epoch(), "1");
}

TEST_F(SharedMissionsTest, AStoreWhoseLeaseIsOverTellsNoRobotWhatItOnceKnew) {
  auto proxy = std::make_unique<CuttingProxy>(server_.port());
  const auto a = Start("a:1", absl::Seconds(3), server_.TcpUri(database_, proxy->port()));
  TestAgent robot(*a, kShared, "robot", map_);
  ASSERT_TRUE(robot.Stream(3).ok());
  a->CloseSession(robot.session());
  const std::string uid = a->GetMission(kShared)->uid;
  proxy->CutAt("UPDATE", CuttingProxy::Moment::kBefore, 1'000'000);
  absl::SleepFor(absl::Milliseconds(3200));
  // Another one has it, and acknowledges more. Nobody has looked after this one's leases, as when a
  // process goes on that was stopped.
  const auto b = Start("b:2");
  const auto entered = EnterOnceLeasesEnd(*b, uid);
  ASSERT_TRUE(entered.ok()) << entered.status();
  ASSERT_TRUE(b->Apply(entered->session_id, robot.NextBatch(1)).ok());
  const auto stale = Enter(*a, kShared, uid);
  EXPECT_TRUE(absl::IsUnavailable(stale.status())) << stale.status();
  // Once it reaches the database again it says where the mission is, and nothing else before that.
  proxy->CutAt("UPDATE", CuttingProxy::Moment::kNever, 0);
  std::string where;
  for (int i = 0; i < 100 && where != "b:2"; ++i) {
    absl::SleepFor(absl::Milliseconds(50));
    const auto asked = Enter(*a, kShared, uid);
    ASSERT_FALSE(asked.ok());
    where = Where(asked.status());
    a->KeepLeases();
  }
  EXPECT_EQ(where, "b:2");
}

TEST_F(SharedMissionsTest, WhatSleepsTooLongGoesWhoeverLooks) {
  const auto a = Start("a:1");
  MissionProfile profile;
  profile.retention_s = 3600;
  ASSERT_TRUE(a->CreateMission(kShared, profile).ok());
  ASSERT_TRUE(a->SleepMission(kShared).ok());
  auto journal = PostgresJournal::Open({.uri = server_.Uri(database_), .lease = absl::Seconds(3)});
  ASSERT_TRUE(journal.ok());
  MapStoreOptions options = DeterministicOptions();
  options.sleep_after_s = 600;
  MapStore later(options, TheWorld().vocabulary, *std::move(journal), nullptr,
                 [] { return absl::Now() + absl::Hours(3); });
  ASSERT_TRUE(later.Recover().ok());
  later.TendMissions();
  EXPECT_TRUE(absl::IsNotFound(a->GetMission(kShared).status()));
}

TEST_F(SharedMissionsTest, AMissionIsMovedWithItsRobots) {
  const auto a = Start("a:1");
  const auto b = Start("b:2");
  const auto c = Start("c:3");
  TestAgent robot(*a, kShared, "robot", map_);
  ASSERT_TRUE(robot.Stream(7).ok());
  const auto pool = SqlPool::Make({.uri = server_.Uri(database_)});
  FleetDirectory fleet(pool->get());
  EXPECT_TRUE(absl::IsNotFound(fleet.Move(kShared, "nowhere:4")));
  EXPECT_TRUE(absl::IsNotFound(fleet.Move("nothing", "b:2")));
  ASSERT_TRUE(fleet.Move(kShared, "b:2").ok());
  absl::Status told;
  for (int i = 0; i < 50 && told.ok(); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    a->KeepLeases();
    told = a->NextShared(robot.session(), 1 << 20).status();
  }
  EXPECT_EQ(Where(told), "b:2") << told;
  EXPECT_EQ(Where(robot.Send(robot.NextBatch(1))), "b:2");
  // Nobody else takes it meanwhile.
  EXPECT_EQ(Where(Enter(*c).status()), "b:2");
  EXPECT_EQ(Where(Enter(*a).status()), "b:2");
  const auto entered = Enter(*b);
  ASSERT_TRUE(entered.ok()) << entered.status();
  EXPECT_EQ(entered->grant.acknowledged[0].number, 7);
  EXPECT_EQ(Where(Enter(*a).status()), "b:2");
}

TEST_F(SharedMissionsTest, ABusyStoreGivesOneMissionToOneThatIsNot) {
  const auto a = Start("a:1");
  ASSERT_TRUE(Enter(*a, "heavy").ok());
  ASSERT_TRUE(Enter(*a, "light").ok());
  const auto pool = SqlPool::Make({.uri = server_.Uri(database_)});
  FleetDirectory fleet(pool->get());
  a->leases()->NoteLoad({{3.6, 4, 50, 100, 2.5}, {{"heavy", {1.6, 20}}, {"light", {0.8, 10}}}, 7});
  const auto look_at_a = [&a] {
    absl::SleepFor(absl::Milliseconds(100));
    a->KeepLeases();
  };
  for (int i = 0; i < 15; ++i) look_at_a();
  EXPECT_EQ(a->ListLoads().size(), 2);  // There is nobody else.
  const auto b = Start("b:2");
  b->leases()->NoteLoad({{0.4, 4, 10, 100, 0.1}});
  ASSERT_TRUE(fleet.SetDuty("b:2", FleetDirectory::Duty::kCordoned).ok());
  for (int i = 0; i < 25; ++i) look_at_a();
  EXPECT_EQ(a->ListLoads().size(), 2);
  auto stores = fleet.ListStores();
  ASSERT_TRUE(stores.ok()) << stores.status();
  ASSERT_TRUE((*stores)[0].load.has_value());
  EXPECT_NEAR((*stores)[0].load->Pressure(), 0.9, 1e-6);
  EXPECT_NEAR((*stores)[0].load->keyframes_per_s, 2.5, 1e-6);
  EXPECT_EQ((*stores)[0].waiting_requests, 7);
  EXPECT_EQ((*stores)[0].since_balanced, absl::InfiniteDuration());
  ASSERT_TRUE(fleet.SetDuty("b:2", FleetDirectory::Duty::kTakesMissions).ok());
  for (int i = 0; i < 50 && a->ListLoads().size() == 2; ++i) look_at_a();
  ASSERT_EQ(a->ListLoads().size(), 1);
  EXPECT_EQ(a->ListLoads()[0].mission, "light");
  EXPECT_EQ(Where(Enter(*a, "heavy").status()), "b:2");
  EXPECT_TRUE(Enter(*b, "heavy").ok());
  EXPECT_EQ(a->leases()->counts().given_to_balance, 1);
  // Whatever they say now, both rest, and what has come stays.
  b->leases()->NoteLoad({{3.9, 4, 10, 100, 3}, {{"heavy", {1.6, 20}}}});
  for (int i = 0; i < 25; ++i) {
    look_at_a();
    b->KeepLeases();
  }
  EXPECT_EQ(a->ListLoads().size(), 1);
  EXPECT_EQ(b->ListLoads().size(), 1);
  stores = fleet.ListStores();
  ASSERT_TRUE(stores.ok()) << stores.status();
  for (const DirectoryStore& store : *stores) EXPECT_LT(store.since_balanced, absl::Minutes(1));
}

TEST_F(SharedMissionsTest, OfTwoStoresThatWouldGiveToOneAtOnceOneDoes) {
  const auto pool = SqlPool::Make({.uri = server_.Uri(database_)});
  const FleetDirectory fleet(pool->get());
  std::vector<std::unique_ptr<MapStore>> stores;
  for (const char* name : {"a:1", "b:2", "c:3"}) stores.push_back(Start(name, absl::Hours(1)));
  for (int round = 0; round < 10; ++round) {
    server_.Ask(database_, "UPDATE corbslam.stores SET balanced_at = NULL");
    std::vector<absl::StatusOr<bool>> begun(2, false);
    std::vector<std::thread> threads;
    for (size_t i = 0; i < begun.size(); ++i) {
      threads.emplace_back([&, i] {
        begun[i] = fleet.BeginBalancing(i == 0 ? "a:1" : "b:2", "c:3", absl::Minutes(1));
      });
    }
    for (std::thread& thread : threads) thread.join();
    ASSERT_TRUE(begun[0].ok() && begun[1].ok()) << begun[0].status() << begun[1].status();
    EXPECT_LE(*begun[0] + *begun[1], 1);
    EXPECT_FALSE(fleet.BeginBalancing("a:1", "c:3", absl::Minutes(1)).value_or(true));
  }
  EXPECT_FALSE(fleet.BeginBalancing("a:1", "nowhere", absl::ZeroDuration()).value_or(true));
  EXPECT_TRUE(fleet.BeginBalancing("a:1", "b:2", absl::ZeroDuration()).value_or(false));
}

TEST_F(SharedMissionsTest, AnOlderProgramUnderAStoresNameSaysNoLoad) {
  const auto a = Start("a:1", absl::Hours(1));
  a->leases()->NoteLoad({{1, 4, 0, 0, 0}});
  const auto pool = SqlPool::Make({.uri = server_.Uri(database_)});
  const FleetDirectory fleet(pool->get());
  // What it prolongs is the lease alone.
  server_.Ask(database_,
              "UPDATE corbslam.stores SET busy_milli = 1000, processors_milli = 4000,"
              " load_until = lease_until");
  EXPECT_TRUE(fleet.ListStores()->front().load.has_value());
  server_.Ask(database_,
              "UPDATE corbslam.stores SET lease_until = lease_until + interval '1 second'");
  EXPECT_FALSE(fleet.ListStores()->front().load.has_value());
}

TEST_F(SharedMissionsTest, StandbysThatCommitsWaitForAreCounted) {
  const auto pool = SqlPool::Make({.uri = server_.Uri(database_)});
  const FleetDirectory fleet(pool->get());
  EXPECT_EQ(fleet.CountStandbys()->wanted, 0);
  const auto wanted = [&](const std::string& names) {
    // Who asks need not be one whose commits wait.
    server_.Ask(database_, "ALTER SYSTEM SET synchronous_standby_names = '" + names + "'");
    server_.Ask(database_, "SELECT pg_reload_conf()");
    absl::SleepFor(absl::Milliseconds(200));
    const auto counted = fleet.CountStandbys();
    EXPECT_TRUE(counted.ok()) << counted.status();
    EXPECT_EQ(counted->there, 0);
    return counted->wanted;
  };
  EXPECT_EQ(wanted("ANY 2 (a, b, c)"), 2);
  EXPECT_EQ(wanted("FIRST 1 (a2, b3)"), 1);
  EXPECT_EQ(wanted("3 (a, b, c)"), 3);
  EXPECT_EQ(wanted("a, b"), 1);
  EXPECT_EQ(wanted("*"), 1);
  server_.Ask(database_, "ALTER SYSTEM RESET synchronous_standby_names");
  server_.Ask(database_, "SELECT pg_reload_conf()");
}

TEST_F(SharedMissionsTest, WhatBecameOfLeasesIsCounted) {
  const auto a = Start("a:1");
  const auto b = Start("b:2");
  TestAgent robot(*a, kShared, "robot", map_);
  ASSERT_TRUE(robot.Stream(7).ok());
  ASSERT_TRUE(EnterOnceLeasesEnd(*b).ok());
  EXPECT_FALSE(robot.Send(robot.NextBatch(1)).ok());
  a->KeepLeases();
  const FleetCounts counts = a->leases()->counts();
  EXPECT_EQ(counts.refused_writes, 1);
  EXPECT_EQ(counts.lost, 1);
  EXPECT_EQ(counts.given, 0);
  EXPECT_TRUE(counts.reaches_database);
  EXPECT_EQ(b->leases()->counts().lost, 0);
}

TEST_F(SharedMissionsTest, AStoreThatIsDrainedGivesAwayAllAndTakesNothing) {
  const auto a = Start("a:1");
  ASSERT_TRUE(Enter(*a, "m1").ok());
  ASSERT_TRUE(Enter(*a, "m2").ok());
  const auto pool = SqlPool::Make({.uri = server_.Uri(database_)});
  FleetDirectory fleet(pool->get());
  ASSERT_TRUE(fleet.SetDuty("a:1", FleetDirectory::Duty::kDrained).ok());
  absl::SleepFor(absl::Milliseconds(1500));
  a->KeepLeases();
  // There is nobody else yet.
  EXPECT_EQ(a->ListLoads().size(), 2);
  ASSERT_TRUE(Enter(*a, "m3").ok());
  const auto b = Start("b:2");
  for (int i = 0; i < 50 && !a->ListLoads().empty(); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    a->KeepLeases();
  }
  EXPECT_TRUE(a->ListLoads().empty());
  for (const char* mission : {"m1", "m2", "m3", "new"}) {
    EXPECT_EQ(Where(Enter(*a, mission).status()), "b:2") << mission;
    EXPECT_TRUE(Enter(*b, mission).ok()) << mission;
  }
  const auto stores = fleet.ListStores();
  ASSERT_TRUE(stores.ok());
  EXPECT_TRUE((*stores)[0].is_drained);
  EXPECT_EQ((*stores)[0].missions, 0);
  EXPECT_EQ((*stores)[1].missions, 4);
  ASSERT_TRUE(fleet.SetDuty("a:1", FleetDirectory::Duty::kTakesMissions).ok());
  absl::SleepFor(absl::Milliseconds(1500));
  EXPECT_TRUE(Enter(*a, "newer").ok());
}

}  // namespace
}  // namespace corbslam::map_store
