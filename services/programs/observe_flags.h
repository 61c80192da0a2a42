// Adds flags for observing a program at work.
#ifndef CORBSLAM_SERVICES_PROGRAMS_OBSERVE_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_OBSERVE_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>

namespace corbslam::services {

// An empty flag turns its part off, which then costs nothing.
struct ObserveFlags {
  std::string metrics_listen;
};

// Adds --metrics-listen (docs/metrics.md).
void AddMetricsFlag(CLI::App& app, ObserveFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_OBSERVE_FLAGS_H_
