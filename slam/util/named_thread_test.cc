#include "slam/util/named_thread.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <memory>
#include <string>

namespace corbslam {
namespace {

TEST(NamedThreadTest, RunsUnderItsName) {
  std::string name;
  // What a thread runs may own what can't be copied.
  auto number = std::make_unique<int>(7);
  int seen = 0;
  std::thread thread = StartThread("fifteen letters", [&, number = std::move(number)] {
    char text[16] = {};
    pthread_getname_np(pthread_self(), text, sizeof(text));
    name = text;
    seen = *number;
  });
  thread.join();
  EXPECT_EQ(name, "fifteen letters");
  EXPECT_EQ(seen, 7);
}

}  // namespace
}  // namespace corbslam
