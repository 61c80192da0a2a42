#include "services/simulation/parallel_rows.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace corbslam {

void ParallelRows(int threads, int rows, const std::function<void(int)>& work) {
  constexpr int kRowsAtOnce = 8;
  std::atomic<int> next = 0;
  const auto run = [&] {
    for (int first = next.fetch_add(kRowsAtOnce); first < rows;
         first = next.fetch_add(kRowsAtOnce)) {
      for (int row = first; row < std::min(rows, first + kRowsAtOnce); ++row) work(row);
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(run);
  run();
  for (std::thread& other : others) other.join();
}

}  // namespace corbslam
