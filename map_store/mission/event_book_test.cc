#include "map_store/mission/event_book.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace corbslam::map_store {
namespace {

std::string AgentOf(const MissionEvent& event) {
  return std::get<MissionEvent::AgentJoined>(event.what).agent;
}

TEST(EventBookTest, TellsOneEventAfterTheOther) {
  absl::Time now = absl::UnixEpoch();
  EventBook book([&now] { return now; });
  EXPECT_FALSE(book.After(0).has_value());
  book.Note(0, MissionEvent::AgentJoined{"a"});
  now += absl::Seconds(3);
  book.Note(7, MissionEvent::AgentLeft{"a"});
  const auto first = book.After(0);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->number, 1u);
  EXPECT_EQ(first->missed, 0u);
  EXPECT_EQ(AgentOf(*first), "a");
  const auto second = book.After(1);
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->number, 2u);
  EXPECT_EQ(second->revision, 7u);
  EXPECT_EQ(second->time - first->time, absl::Seconds(3));
  EXPECT_TRUE(std::holds_alternative<MissionEvent::AgentLeft>(second->what));
  EXPECT_FALSE(book.After(2).has_value());
}

TEST(EventBookTest, GoesOnFromItsPast) {
  EventBook book(&absl::Now);
  const uint64_t all = EventBook::kMaxEventsAsleep + 5;
  for (uint64_t i = 1; i <= all; ++i) {
    book.Note(0, MissionEvent::AgentJoined{std::to_string(i)});
  }
  EventBook later(&absl::Now);
  later.GoOnFrom(book.GetPast());
  EXPECT_EQ(AgentOf(*later.After(0)), "6");
  EXPECT_EQ(later.After(0)->missed, 5u);
  EXPECT_FALSE(later.After(all).has_value());
  later.Note(0, MissionEvent::AgentJoined{"new"});
  EXPECT_EQ(later.After(all)->number, all + 1);
  EventBook empty(&absl::Now);
  empty.GoOnFrom(EventBook(&absl::Now).GetPast());
  EXPECT_FALSE(empty.After(0).has_value());
}

TEST(EventBookTest, SaysHowManyItHasForgotten) {
  EventBook book(&absl::Now);
  const uint64_t all = EventBook::kMaxEvents + 5;
  for (uint64_t i = 1; i <= all; ++i) {
    book.Note(0, MissionEvent::AgentJoined{std::to_string(i)});
  }
  const auto oldest = book.After(0);
  ASSERT_TRUE(oldest.has_value());
  EXPECT_EQ(oldest->number, 6u);
  EXPECT_EQ(oldest->missed, 5u);
  EXPECT_EQ(AgentOf(*oldest), "6");
  EXPECT_EQ(book.After(3)->missed, 2u);
  EXPECT_EQ(book.After(5)->missed, 0u);
  EXPECT_EQ(book.After(6)->number, 7u);
  EXPECT_EQ(book.After(all - 1)->number, all);
  EXPECT_FALSE(book.After(all).has_value());
}

TEST(EventBookTest, ANumberOfAnEarlierLifeIsNone) {
  EventBook book(&absl::Now);
  EXPECT_FALSE(book.After(500).has_value());
  book.Note(0, MissionEvent::AgentJoined{"a"});
  ASSERT_TRUE(book.After(500).has_value());
  EXPECT_EQ(book.After(500)->number, 1u);
  EXPECT_EQ(book.After(500)->missed, 0u);
}

TEST(EventBookTest, CallsListenersOnceThereIsNews) {
  EventBook book(&absl::Now);
  int calls = 0;
  const uint64_t token = book.listeners().AddOfMap([&] {
    ++calls;
    EXPECT_TRUE(book.After(0).has_value()) << "a listener may ask";
  });
  book.Tell();
  EXPECT_EQ(calls, 0);
  book.Note(0, MissionEvent::AgentJoined{"a"});
  book.Note(0, MissionEvent::AgentLeft{"a"});
  EXPECT_EQ(calls, 0);
  book.Tell();
  book.Tell();
  EXPECT_EQ(calls, 1);
  book.listeners().RemoveOfMap(token);
  book.Note(0, MissionEvent::AgentJoined{"a"});
  book.Tell();
  EXPECT_EQ(calls, 1);
}

TEST(EventBookTest, ThreadsRecordWhileOthersRead) {
  EventBook book(&absl::Now);
  constexpr int kThreads = 4;
  constexpr int kEach = 1000;
  std::atomic<int> writing = kThreads;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < kEach; ++i) {
        book.Note(0, MissionEvent::GlobalLayerForgotten{});
        book.Tell();
      }
      --writing;
    });
  }
  uint64_t known = 0;
  uint64_t counted = 0;
  while (writing > 0 || book.After(known).has_value()) {
    const auto event = book.After(known);
    if (!event.has_value()) continue;
    EXPECT_EQ(event->number, known + event->missed + 1);
    counted += 1 + event->missed;
    known = event->number;
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(counted, uint64_t{kThreads * kEach});
}

}  // namespace
}  // namespace corbslam::map_store
