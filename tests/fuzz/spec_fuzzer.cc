// Feeds names of sources as on the command line and in configurations, simulations included. What
// is accepted is written and read again the same.
#include <cstdlib>
#include <string>

#include "client_agent/source/source_spec.h"
#include "services/simulated_source/simulated_source.h"
#include "services/simulation/sequence/simulation_options.h"
#include "tests/fuzz/messages.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;                // NOLINT
  using namespace corbslam::client_agent;  // NOLINT
  using namespace corbslam::services;      // NOLINT
  using namespace corbslam::tests;         // NOLINT
  RegisterSimulatedSources();
  const absl::string_view text = AsText(data, size);
  const auto spec = ParseSourceSpec(text);
  if (spec.ok()) {
    const std::string written = FormatSourceSpec(*spec);
    const auto again = ParseSourceSpec(written);
    if (!again.ok() || FormatSourceSpec(*again) != written) std::abort();
    if (again->perturbation.gamma != spec->perturbation.gamma) std::abort();
    if (again->perturbation.noise_sigma != spec->perturbation.noise_sigma) std::abort();
    for (const size_t frames : {size_t{0}, size_t{1}, size_t{1000}}) (void)FramesOf(*spec, frames);
  }
  SourceSpec options;
  (void)ApplyOptions(text, options);
  const size_t equals = text.find('=');
  if (equals == absl::string_view::npos || !IsSimulationOption(text.substr(0, equals))) return 0;
  SimulationSpec simulation;
  (void)ApplySimulationOption(text.substr(0, equals), text.substr(equals + 1), simulation);
  return 0;
}
