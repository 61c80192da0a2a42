// Eight numbers in memory, as vector code takes them: for headers and calls between files.
#ifndef CORBSLAM_SERVICES_SIMULATION_EIGHT_H_
#define CORBSLAM_SERVICES_SIMULATION_EIGHT_H_

#include <array>

namespace corbslam {

constexpr int kNumbers = 8;

template <typename T>
struct alignas(kNumbers * sizeof(T)) Eight {
  std::array<T, kNumbers> lanes;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_EIGHT_H_
