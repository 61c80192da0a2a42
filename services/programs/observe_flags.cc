#include "services/programs/observe_flags.h"

#include "services/command_line/help_formatter.h"

namespace corbslam::services {

void AddMetricsFlag(CLI::App& app, ObserveFlags& flags) {
  app.add_option("--metrics-listen", flags.metrics_listen,
                 "IP:PORT on which Prometheus reads metrics, without TLS; without: nowhere")
      ->capture_default_str();
}

void AddTraceFlag(CLI::App& app, ObserveFlags& flags) {
  app.add_option("--trace-file", flags.trace_file,
                 "File to write the keyframes' ways to, as Chrome's trace events")
      ->capture_default_str()
      ->group(kRareGroup);
}

}  // namespace corbslam::services
