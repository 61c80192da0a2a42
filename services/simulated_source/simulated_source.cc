#include "services/simulated_source/simulated_source.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client_agent/source/source_kinds.h"
#include "services/simulated_source/measured_imu.h"
#include "services/simulated_source/simulated_pair.h"
#include "services/simulated_source/simulated_reader.h"
#include "services/simulation/sequence/simulation_options.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FrameReader;
using client_agent::KindSettings;
using client_agent::RegisterSourceKind;
using client_agent::SharedKindSettings;
using client_agent::SourceSpec;

namespace {

constexpr char kKind[] = "sim";

class SimulationSettings : public KindSettings {
 public:
  explicit SimulationSettings(SimulationSpec spec) : spec_(std::move(spec)) {}

  const SimulationSpec& spec() const { return spec_; }

  absl::string_view kind() const override { return kKind; }
  std::vector<absl::string_view> OptionNames() const override { return SimulationOptionNames(); }
  absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                          absl::string_view value) const override {
    SimulationSpec changed = spec_;
    if (key == "rig" && IsFile(value)) {
      ASSIGN_OR_RETURN(changed.pair, ReadSimulatedPair(std::string(value)));
      changed.rig.reset();
    } else if (key == "imu" && IsFile(value)) {
      ASSIGN_OR_RETURN(changed.imu, ReadMeasuredImu(std::string(value), spec_.imu));
    } else {
      RETURN_IF_ERROR(ApplySimulationOption(key, value, changed));
    }
    return std::make_shared<SimulationSettings>(std::move(changed));
  }
  absl::Status Validate() const override { return corbslam::Validate(spec_); }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override {
    return FormatSimulationOptions(spec_);
  }
  uint64_t noise_seed() const override { return spec_.lens.noise_seed; }
  bool turned() const override { return spec_.turned; }
  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return OpenSimulation(spec_);
  }

 private:
  const SimulationSpec spec_;
};

absl::StatusOr<SharedKindSettings> MakeSettings(absl::string_view world) {
  SimulationSpec spec;
  ASSIGN_OR_RETURN(spec.world, ParseSimulatedWorld(world));
  return std::make_shared<SimulationSettings>(std::move(spec));
}

}  // namespace

bool RegisterSimulatedSources() {
  RegisterSourceKind({kKind, "sim:WORLD", &MakeSettings});
  return true;
}

const SimulationSpec* FindSimulation(const SourceSpec& source) {
  const auto* settings = dynamic_cast<const SimulationSettings*>(source.settings.get());
  return settings == nullptr ? nullptr : &settings->spec();
}

void SetSimulation(const SimulationSpec& simulation, SourceSpec& source) {
  source.settings = std::make_shared<SimulationSettings>(simulation);
}

}  // namespace corbslam::services
