#include "slam/util/named_thread.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <memory>
#include <string>

namespace corbslam {
namespace {

std::string NameOfThisThread() {
  char text[16] = {};
  pthread_getname_np(pthread_self(), text, sizeof(text));
  return text;
}

TEST(NamedThreadTest, RunsUnderItsName) {
  std::string name;
  // What a thread runs may own what can't be copied.
  auto number = std::make_unique<int>(7);
  int seen = 0;
  std::thread thread = StartThread("fifteen letters", [&, number = std::move(number)] {
    name = NameOfThisThread();
    seen = *number;
  });
  thread.join();
  EXPECT_EQ(name, "fifteen letters");
  EXPECT_EQ(seen, 7);
}

TEST(NamedThreadTest, AFutureHasWhatANamedThreadReturns) {
  const std::string own = NameOfThisThread();
  std::future<std::string> name = StartAsync("returns its own", [] { return NameOfThisThread(); });
  EXPECT_EQ(name.get(), "returns its own");
  EXPECT_EQ(NameOfThisThread(), own);
}

}  // namespace
}  // namespace corbslam
