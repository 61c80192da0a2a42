#include "services/programs/observe_flags.h"

#include "services/command_line/setting.h"

namespace corbslam::services {

void AddMetricsFlag(CLI::App& app, ObserveFlags& flags) {
  AddSettings(app, {{"--metrics-listen", &flags.metrics_listen,
                     "IP:PORT on which Prometheus reads metrics, without TLS; without: nowhere"}});
}

}  // namespace corbslam::services
