#include "map_store/state/query_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};
constexpr KeyframeId Ka(uint32_t index) { return {kA, index}; }

// The query's index, the candidates' local map, and the attempts.
using Task = std::tuple<uint32_t, uint64_t, int>;
std::vector<Task> Tasks(const QueryQueue& queue) {
  std::vector<Task> tasks;
  for (const QueryTask& task : queue.ToTasks()) {
    tasks.push_back({task.query.index, task.against.value, task.attempts});
  }
  return tasks;
}

TEST(QueryQueueTest, GivesATaskForEachLocalMapInOrder) {
  QueryQueue queue;
  queue.Push(Ka(1), {kA});
  queue.Push(Ka(2), {kA, kB});
  queue.Push(Ka(3), {});
  queue.Push(Ka(4), {kA, kB});
  EXPECT_EQ(queue.size(), 5u);
  EXPECT_THAT(Tasks(queue), ElementsAre(Task{1, 0xa, 0}, Task{2, 0xa, 0}, Task{2, 0xb, 0},
                                        Task{4, 0xa, 0}, Task{4, 0xb, 0}));
  std::vector<Task> taken;
  while (!queue.empty()) {
    taken.push_back({queue.front().query.index, queue.front().against.value, 0});
    queue.PopFront();
  }
  EXPECT_EQ(queue.size(), 0u);
  EXPECT_THAT(taken, ElementsAre(Task{1, 0xa, 0}, Task{2, 0xa, 0}, Task{2, 0xb, 0}, Task{4, 0xa, 0},
                                 Task{4, 0xb, 0}));
}

TEST(QueryQueueTest, CountsTheFirstTasksAttempts) {
  QueryQueue queue;
  queue.Push(Ka(1), {kA, kB});
  EXPECT_EQ(queue.CountFailureOfFront(), 1);
  EXPECT_EQ(queue.CountFailureOfFront(), 2);
  EXPECT_THAT(Tasks(queue), ElementsAre(Task{1, 0xa, 2}, Task{1, 0xb, 0}));
  EXPECT_THAT(Tasks(QueryQueue(queue.ToTasks())), ElementsAre(Task{1, 0xa, 2}, Task{1, 0xb, 0}));
  queue.PopFront();
  EXPECT_EQ(queue.CountFailureOfFront(), 1);
}

TEST(QueryQueueTest, TakesATaskOutWithThoseBeforeIt) {
  QueryQueue queue;
  for (uint32_t i = 1; i <= 3; ++i) queue.Push(Ka(i), {kA, kB});
  queue.TakeUntil({Ka(9), kA, 0});
  EXPECT_EQ(queue.size(), 6u);
  queue.TakeUntil({Ka(2), kA, 0});
  EXPECT_THAT(Tasks(queue), ElementsAre(Task{2, 0xb, 0}, Task{3, 0xa, 0}, Task{3, 0xb, 0}));
  queue.TakeUntil({Ka(2), kA, 0});  // This task is not there any more.
  EXPECT_EQ(queue.size(), 3u);
  queue.TakeUntil({Ka(2), kB, 0});
  EXPECT_THAT(Tasks(queue), ElementsAre(Task{3, 0xa, 0}, Task{3, 0xb, 0}));
  queue.TakeUntil({Ka(3), kB, 0});
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.size(), 0u);
}

// Local maps take turns, so that what stands before an answered task may be unanswered.
TEST(QueryQueueTest, TakesNoOtherLocalMapsTasks) {
  QueryQueue queue;
  queue.Push({kB, 1}, {kA});
  queue.Push(Ka(1), {kB});
  queue.Push({kB, 2}, {kA});
  queue.Push(Ka(2), {kA, kB});
  queue.ChooseOfFront({kA});
  queue.TakeUntil({Ka(2), kA, 0});
  EXPECT_TRUE(queue.IsFrontChosen()) << "the front is still the same";
  EXPECT_EQ(queue.size(), 3u);
  EXPECT_THAT(Tasks(queue), ElementsAre(Task{1, 0xa, 0}, Task{2, 0xa, 0}, Task{2, 0xb, 0}));
  EXPECT_EQ(queue.front().query, (KeyframeId{kB, 1}));
}

TEST(QueryQueueTest, BringsALocalMapsFirstKeyframeForward) {
  QueryQueue queue;
  queue.Push(Ka(1), {kB});
  queue.Push(Ka(2), {kB});
  queue.Push({kB, 7}, {kA});
  queue.Push({kB, 8}, {kA});
  EXPECT_THAT(queue.WaitingLocalMaps(), ElementsAre(kA, kB));
  queue.CountFailureOfFront();
  queue.BringForward(kB);
  EXPECT_THAT(queue.WaitingLocalMaps(), ElementsAre(kB, kA));
  EXPECT_THAT(Tasks(queue),
              ElementsAre(Task{7, 0xa, 0}, Task{1, 0xb, 0}, Task{2, 0xb, 0}, Task{8, 0xa, 0}));
  queue.BringForward(kB);
  queue.BringForward({0xc});
  EXPECT_EQ(queue.front().query.index, 7u);
  EXPECT_EQ(queue.size(), 4u);
}

// Indices of the local map's keyframes that wait.
std::vector<uint32_t> Waiting(const QueryQueue& queue, LocalMapId local_map) {
  std::vector<uint32_t> indices;
  for (const QueryTask& task : queue.ToTasks()) {
    if (task.query.local_map == local_map) indices.push_back(task.query.index);
  }
  return indices;
}

// A worker that is short of time costs queries next to others, not a queue without end.
TEST(QueryQueueTest, OfALocalMapSoManyWaitAtMost) {
  constexpr uint32_t kPushed = 10 * QueryQueue::kMostOfLocalMap;
  QueryQueue queue;
  queue.Push({kB, 1}, {kA});
  for (uint32_t i = 1; i <= kPushed; ++i) {
    queue.Push(Ka(i), {kB});
    queue.ThinOut(kA);
  }
  const std::vector<uint32_t> waiting = Waiting(queue, kA);
  EXPECT_EQ(waiting.size(), QueryQueue::kMostOfLocalMap);
  EXPECT_EQ(queue.size(), waiting.size() + 1);
  EXPECT_EQ(waiting.front(), 1u);
  EXPECT_EQ(waiting.back(), kPushed);
  uint32_t widest = 0;
  for (size_t i = 1; i < waiting.size(); ++i) {
    widest = std::max(widest, waiting[i] - waiting[i - 1]);
  }
  EXPECT_LE(widest, 2 * kPushed / QueryQueue::kMostOfLocalMap) << "no place is left out";
}

TEST(QueryQueueTest, ThinsOutNeitherOthersNorTheFront) {
  QueryQueue queue;
  for (uint32_t i = 1; i <= QueryQueue::kMostOfLocalMap; ++i) queue.Push(Ka(i), {kB});
  queue.Push({kB, 1}, {kA});
  queue.ThinOut(kA);
  queue.ThinOut(kB);
  EXPECT_EQ(queue.size(), QueryQueue::kMostOfLocalMap + 1);
  queue.ChooseOfFront({kB});
  queue.Push(Ka(1000), {kB});
  queue.ThinOut(kA);
  EXPECT_TRUE(queue.IsFrontChosen());
  EXPECT_EQ(queue.front().query, Ka(1));
  EXPECT_EQ(Waiting(queue, kA).size(), QueryQueue::kMostOfLocalMap);
}

// A worker that stands still while robots come and go leaves no queue without end, either.
TEST(QueryQueueTest, OfManyLocalMapsThatEndedFewWait) {
  constexpr uint32_t kOfEach = QueryQueue::kMostOfLocalMap;
  constexpr uint64_t kEnded = 10;
  constexpr LocalMapId kOpen{1000};
  QueryQueue queue;
  for (uint32_t i = 1; i <= kOfEach; ++i) queue.Push({kOpen, i}, {kA});
  for (uint64_t id = 1; id <= kEnded; ++id) {
    for (uint32_t i = 1; i <= kOfEach; ++i) queue.Push({LocalMapId{id}, i}, {kA});
    queue.ThinOutEnded(LocalMapId{id}, [kOpen](LocalMapId waiting) { return !(waiting == kOpen); });
  }
  EXPECT_EQ(Waiting(queue, kOpen).size(), kOfEach);
  const size_t ended_whole = QueryQueue::kMostOfEnded / kOfEach;
  EXPECT_EQ(Waiting(queue, LocalMapId{ended_whole}).size(), kOfEach);
  for (uint64_t id = ended_whole + 1; id <= kEnded; ++id) {
    const std::vector<uint32_t> waiting = Waiting(queue, LocalMapId{id});
    EXPECT_EQ(waiting.size(), QueryQueue::kFewestOfEnded) << "local map " << id;
    EXPECT_EQ(waiting.front(), 1u) << "local map " << id;
    EXPECT_EQ(waiting.back(), kOfEach) << "local map " << id;
  }
}

TEST(QueryQueueTest, AShortLocalMapThatEndedWaitsWhole) {
  QueryQueue queue;
  for (uint32_t i = 1; i <= QueryQueue::kMostOfEnded; ++i) queue.Push({kB, i}, {kA});
  for (uint32_t i = 1; i <= QueryQueue::kFewestOfEnded; ++i) queue.Push(Ka(i), {kB});
  queue.ThinOutEnded(kA, [](LocalMapId) { return true; });
  EXPECT_EQ(queue.size(), QueryQueue::kMostOfEnded + QueryQueue::kFewestOfEnded);
}

TEST(QueryQueueTest, LooksUpAKeyframeWhereItWasChosenTo) {
  QueryQueue queue;
  constexpr LocalMapId kC{0xc};
  for (uint32_t i = 1; i <= 3; ++i) queue.Push(Ka(i), {kA, kB, kC});
  queue.PopFront();
  EXPECT_FALSE(queue.IsFrontChosen());
  EXPECT_THAT(queue.AgainstOfFront(), ElementsAre(kB, kC));
  queue.ChooseOfFront({kC});
  EXPECT_TRUE(queue.IsFrontChosen());
  EXPECT_EQ(queue.size(), 7u);
  EXPECT_THAT(Tasks(queue),
              ElementsAre(Task{1, 0xc, 0}, Task{2, 0xa, 0}, Task{2, 0xb, 0}, Task{2, 0xc, 0},
                          Task{3, 0xa, 0}, Task{3, 0xb, 0}, Task{3, 0xc, 0}));
  QueryQueue answered = queue;
  answered.TakeUntil({Ka(1), kC, 0});
  EXPECT_FALSE(answered.IsFrontChosen());
  queue.PopFront();
  EXPECT_FALSE(queue.IsFrontChosen());
  queue.ChooseOfFront({});
  EXPECT_THAT(Tasks(queue), ElementsAre(Task{3, 0xa, 0}, Task{3, 0xb, 0}, Task{3, 0xc, 0}));
  EXPECT_EQ(queue.size(), 3u);
}

TEST(QueryQueueTest, CountsByLocalMaps) {
  QueryQueue queue;
  for (uint32_t i = 1; i <= 3; ++i) queue.Push(Ka(i), {kA, kB});
  queue.Push({kB, 1}, {kA, kB});
  queue.PopFront();
  EXPECT_THAT(queue.CountByPair(), ElementsAre(Pair(Pair(kA, kA), 2), Pair(Pair(kA, kB), 3),
                                               Pair(Pair(kB, kA), 1), Pair(Pair(kB, kB), 1)));
  queue.Clear();
  EXPECT_THAT(queue.CountByPair(), IsEmpty());
}

}  // namespace
}  // namespace corbslam::map_store
