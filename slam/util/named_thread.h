// Starts threads under names that `top -H`, `ps -L` and debuggers show. The table of threads in
// docs/map.md has each of them.
#ifndef CORBSLAM_SLAM_UTIL_NAMED_THREAD_H_
#define CORBSLAM_SLAM_UTIL_NAMED_THREAD_H_

#include <cstddef>
#include <future>
#include <thread>
#include <utility>

namespace corbslam {

// Gives the calling thread a name of at most 15 letters.
void NameThisThread(const char* name);

// Starts a thread that runs `run`. The name is a literal, since a test reads the names in the
// sources.
template <size_t kSize, typename Run>
[[nodiscard]] std::thread StartThread(const char (&name)[kSize], Run&& run) {
  static_assert(kSize <= 16, "Linux keeps 15 letters of a thread's name");
  return std::thread(
      [text = static_cast<const char*>(name), run = std::forward<Run>(run)]() mutable {
        NameThisThread(text);
        run();
      });
}

// The same of what returns something: the future has it, and waits for the thread when it goes.
template <size_t kSize, typename Run>
[[nodiscard]] auto StartAsync(const char (&name)[kSize], Run&& run) {
  static_assert(kSize <= 16, "Linux keeps 15 letters of a thread's name");
  return std::async(std::launch::async, [text = static_cast<const char*>(name),
                                         run = std::forward<Run>(run)]() mutable {
    NameThisThread(text);
    return run();
  });
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_NAMED_THREAD_H_
