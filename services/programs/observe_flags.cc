#include "services/programs/observe_flags.h"

namespace corbslam::services {

void AddMetricsFlag(CLI::App& app, ObserveFlags& flags) {
  app.add_option("--metrics-listen", flags.metrics_listen,
                 "IP:PORT on which Prometheus reads metrics, without TLS; without: nowhere")
      ->capture_default_str();
}

}  // namespace corbslam::services
