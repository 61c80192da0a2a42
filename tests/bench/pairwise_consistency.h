// Finds overlaps that agree with each other pair by pair.
#ifndef CORBSLAM_TESTS_BENCH_PAIRWISE_CONSISTENCY_H_
#define CORBSLAM_TESTS_BENCH_PAIRWISE_CONSISTENCY_H_

#include <vector>

#include "tests/bench/aliased_graph.h"

namespace corbslam::tests {

// Returns 1 for the overlaps of the largest set, between each two local maps, of which every two
// agree: the way round through both and the odometry between them leads back to where it began,
// within the noise (equation 7 of Mangelson et al., ICRA 2018). It returns 0 for the others. The
// largest set is searched greedily from each overlap, as in their section IV.
std::vector<double> ConsistentOverlaps(const AliasedGraph& graph);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_PAIRWISE_CONSISTENCY_H_
