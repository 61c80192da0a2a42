#include "client_agent/source/bag/bag_source.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client_agent/source/bag/bag_options.h"
#include "client_agent/source/bag/bag_reader.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_kinds.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

class BagSettings : public KindSettings {
 public:
  explicit BagSettings(BagOptions options) : options_(std::move(options)) {}

  absl::string_view kind() const override { return "bag"; }
  std::vector<absl::string_view> OptionNames() const override { return BagOptionNames(); }
  absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                          absl::string_view value) const override {
    BagOptions changed = options_;
    RETURN_IF_ERROR(ApplyBagOption(key, value, changed));
    return std::make_shared<BagSettings>(std::move(changed));
  }
  absl::Status Validate() const override { return client_agent::Validate(options_); }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override {
    return FormatBagOptions(options_);
  }
  uint64_t noise_seed() const override { return 1; }
  bool turned() const override { return false; }
  bool trusts_calibration() const override { return options_.trust_calibration; }
  const BagOptions& options() const { return options_; }
  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override { return OpenBag(options_); }

 private:
  const BagOptions options_;
};

}  // namespace

void RegisterBagSource() {
  RegisterSourceKind(
      {"bag", "bag:BAG", [](absl::string_view path) -> absl::StatusOr<SharedKindSettings> {
         BagOptions options;
         options.path = std::string(path);
         return std::make_shared<BagSettings>(std::move(options));
       }});
}

const BagOptions* FindBag(const SourceSpec& source) {
  const auto* settings = dynamic_cast<const BagSettings*>(source.settings.get());
  return settings == nullptr ? nullptr : &settings->options();
}

}  // namespace corbslam::client_agent
