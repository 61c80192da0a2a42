#ifndef CORBSLAM_SERVICES_SIMULATION_PARALLEL_ROWS_H_
#define CORBSLAM_SERVICES_SIMULATION_PARALLEL_ROWS_H_

#include <functional>

namespace corbslam {

// Calls `work(row)` once for each row < rows, on this thread and threads - 1 others; returns when
// all are done.
void ParallelRows(int threads, int rows, const std::function<void(int)>& work);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_PARALLEL_ROWS_H_
