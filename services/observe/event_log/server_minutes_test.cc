#include "services/observe/event_log/server_minutes.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

StoreMinute GoodMinute() {
  StoreMinute minute;
  minute.robots = 2;
  minute.missions = 1;
  minute.keyframes = 1240;
  minute.new_keyframes = 90;
  minute.waiting_requests = 3;
  minute.rss_bytes = 512 << 20;
  minute.memory_budget_bytes = uint64_t{2} << 30;
  minute.disk = {uint64_t{93} << 20, uint64_t{20} << 30};
  return minute;
}

TEST(ServerMinutesTest, AStoreThatFaresWell) {
  EXPECT_EQ(FormatMinute(GoodMinute()),
            "2 robots connected; 1240 keyframes (+90) in 1 mission; 3 fusion requests wait; memory "
            "512.0 MiB of 2048.0 MiB (25 %); disk 93.0 MiB, 20.0 GiB free");
}

TEST(ServerMinutesTest, AStoresTroublesComeFirst) {
  StoreMinute minute = GoodMinute();
  minute.writable = absl::ResourceExhaustedError("/var/lib/corbslam has 12 MiB left");
  minute.damaged_missions = 1;
  minute.outage = {absl::Milliseconds(125900), "worker.lan:50052 refuses connections"};
  minute.refused = 4;
  minute.disk.reset();
  minute.memory_budget_bytes = 0;
  minute.new_keyframes = -7;
  EXPECT_EQ(FormatMinute(minute),
            "takes nothing in: /var/lib/corbslam has 12 MiB left; 1 mission damaged; no fusion "
            "worker for 2m5s: worker.lan:50052 refuses connections; 4 times something was refused "
            "for want of memory; 2 robots connected; 1240 keyframes (-7) in 1 mission; 3 fusion "
            "requests wait; memory 512.0 MiB");
}

TEST(ServerMinutesTest, AStoreThatWasJustStarted) {
  StoreMinute minute;
  minute.has_worker = false;
  EXPECT_EQ(FormatMinute(minute),
            "has no fusion worker; 0 robots connected; 0 keyframes (+0) in 0 missions; 0 fusion "
            "requests wait; memory 0.0 MiB");
}

TEST(ServerMinutesTest, AWorker) {
  WorkerMinute minute;
  minute.held = 2;
  minute.waiting = 1;
  minute.done = 31;
  minute.cpu_s = 90;
  minute.took = absl::Seconds(60);
  minute.rss_bytes = 300 << 20;
  EXPECT_EQ(FormatMinute(minute),
            "31 requests done; 2 held, of which 1 waits; 1.5 processors busy; memory 300.0 MiB");
  minute.failed = 1;
  minute.cancelled = 2;
  minute.took = absl::ZeroDuration();
  EXPECT_EQ(FormatMinute(minute),
            "1 request failed; 31 requests done; 2 requests cancelled; 2 held, of which 1 waits; "
            "0.0 processors busy; memory 300.0 MiB");
}

TEST(ServerMinutesTest, AViewer) {
  ViewerMinute minute;
  minute.pages = 3;
  minute.missions = 1;
  minute.rss_bytes = 100 << 20;
  EXPECT_EQ(FormatMinute(minute), "3 pages open; 1 mission followed; memory 100.0 MiB");
  minute.store_answers = false;
  minute.pages = 1;
  EXPECT_EQ(FormatMinute(minute),
            "the map store is not reached; 1 page open; 1 mission followed; memory 100.0 MiB");
}

}  // namespace
}  // namespace corbslam::services
