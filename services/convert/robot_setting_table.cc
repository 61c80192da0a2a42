#include "services/convert/robot_setting_table.h"

#include <array>
#include <charconv>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "services/convert/limits.h"
#include "services/convert/resource_names.h"
#include "slam/exchange/share_modes.h"
#include "slam/features/feature_limits.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using google::protobuf::FieldDescriptor;

std::string WantedUpload(const std::string& value) {
  uint32_t number = 0;
  const bool is_number = absl::SimpleAtoi(value, &number) && number > 0 &&
                         number <= kMostFeatures && value == absl::StrCat(number);
  if (value == "all" || value == "mapped" || is_number) return "";
  return absl::StrCat("all, mapped or a number from 1 to ", kMostFeatures);
}

std::string WantedShare(const std::string& value) {
  return FindNamed(kShareModes, value).has_value() ? "" : JoinNames(kShareModes, ", ");
}

// Only a robot knows the size of its pictures.
std::string WantedMask(const std::string& png) {
  constexpr absl::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
  const bool is_complete =
      absl::string_view(png).substr(0, kPngSignature.size()) == kPngSignature &&
      PictureSize(png).ok() && !IsCutShort(png);
  return png.empty() || is_complete ? "" : "a PNG, and a whole one";
}

constexpr NumberRange kFeatures = {kLeastFeatures, kMostFeatures};
constexpr NumberRange kRate_hz = {0.1, 1000, "all"};
constexpr NumberRange kMemory_bytes = {kLeastMemoryBudget_bytes, uint64_t{1} << 50, "no bound",
                                       true};

constexpr RobotSetting kTable[] = {
    {"features", "features", "Features of a picture", kFeatures},
    {"max-rate", "max_frame_rate_hz", "Frames a second at most; 0: all", kRate_hz},
    {.flag = "memory-budget",
     .field = "memory_budget_bytes",
     .text = "MiB of the robot's process; 0: no bound",
     .in = kMemory_bytes,
     .tool_flag = "memory-budget-mb",
     .tool_unit = uint64_t{1} << 20},
    {.flag = "upload",
     .field = "upload_features",
     .text = "features=all, features=mapped or features=N",
     .wanted = &WantedUpload,
     .prefix = "features="},
    {"share", "share", "none, corrections, nearby or everything", {}, &WantedShare},
    {"share-radius", "share_radius_m", "Metres, with --share nearby", kShareRadius_m},
    {"uplink-kbps", "uplink_kbps", "Kilobits a second that the robot sends at most; 0: no bound",
     kLink_kbps},
    {.flag = "mask",
     .field = "mask_png",
     .text = "PNG that is 0 where nothing is to be looked at",
     .wanted = &WantedMask,
     .is_file = true},
};

const FieldDescriptor* FieldOf(const RobotSetting& row) {
  return v1::RobotSettings::descriptor()->FindFieldByName(row.field);
}

// Returns a text that is read as the same number.
std::string TextOf(double number) {
  std::array<char, 400> text;
  const auto end = std::to_chars(text.begin(), text.end(), number, std::chars_format::fixed).ptr;
  return {text.begin(), end};
}

double NumberOf(const RobotSetting& row, const v1::RobotSettings& settings) {
  const FieldDescriptor* field = FieldOf(row);
  const google::protobuf::Reflection& values = *settings.GetReflection();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_UINT32:
      return values.GetUInt32(settings, field);
    case FieldDescriptor::CPPTYPE_UINT64:
      return static_cast<double>(values.GetUInt64(settings, field));
    default:
      return values.GetDouble(settings, field);
  }
}

std::string ValueText(const RobotSetting& row, const v1::RobotSettings& settings, uint64_t unit) {
  if (row.wanted == nullptr) return TextOf(NumberOf(row, settings) / static_cast<double>(unit));
  return settings.GetReflection()->GetString(settings, FieldOf(row));
}

absl::Status BadSetting(absl::string_view field, absl::string_view value,
                        absl::string_view wanted) {
  return absl::InvalidArgumentError(absl::StrCat("the settings' ", field, " is ",
                                                 absl::CHexEscape(value.substr(0, 80)),
                                                 ", must be ", wanted));
}

absl::Status Check(const RobotSetting& row, const v1::RobotSettings& settings) {
  const std::string value = ValueText(row, settings, 1);
  std::string wanted;
  if (row.wanted != nullptr) {
    wanted = row.wanted(value);
  } else if (!row.in.Contains(NumberOf(row, settings))) {
    wanted = DescribeRange(row.in, IsInteger(row));
  }
  if (wanted.empty()) return absl::OkStatus();
  return BadSetting(row.field, row.is_file ? absl::StrCat(value.size(), " bytes") : value, wanted);
}

absl::Status CheckTogether(const v1::RobotSettings& settings) {
  const std::string& share = settings.share();
  if (settings.memory_budget_bytes() > 0 && share == "everything") {
    return BadSetting("memory_budget_bytes", absl::StrCat(settings.memory_budget_bytes()),
                      "left out or 0 with share = everything, which has no bound in memory");
  }
  if (!settings.has_share_radius_m() || !settings.has_share() || share == "nearby") {
    return absl::OkStatus();
  }
  return BadSetting("share_radius_m", absl::StrCat(settings.share_radius_m()),
                    absl::StrCat("left out with share = ", share, ": it is of share = nearby"));
}

}  // namespace

absl::Span<const RobotSetting> RobotSettingTable() { return kTable; }

NumberRange RangeOfRobotSetting(absl::string_view flag) {
  for (const RobotSetting& row : kTable) {
    if (row.flag == flag) return row.in;
  }
  return {};
}

bool HasSetting(const RobotSetting& row, const v1::RobotSettings& settings) {
  return settings.GetReflection()->HasField(settings, FieldOf(row));
}

void ClearSetting(const RobotSetting& row, v1::RobotSettings& settings) {
  settings.GetReflection()->ClearField(&settings, FieldOf(row));
}

bool IsInteger(const RobotSetting& row) {
  return FieldOf(row)->cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE;
}

void SetNumber(const RobotSetting& row, double number, v1::RobotSettings& settings) {
  const FieldDescriptor* field = FieldOf(row);
  const google::protobuf::Reflection& values = *settings.GetReflection();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_UINT32:
      return values.SetUInt32(&settings, field, static_cast<uint32_t>(number));
    case FieldDescriptor::CPPTYPE_UINT64:
      return values.SetUInt64(&settings, field, static_cast<uint64_t>(number));
    default:
      return values.SetDouble(&settings, field, number);
  }
}

void SetText(const RobotSetting& row, const std::string& text, v1::RobotSettings& settings) {
  settings.GetReflection()->SetString(&settings, FieldOf(row), text);
}

std::string SettingText(const RobotSetting& row, const v1::RobotSettings& settings, uint64_t unit) {
  const std::string text = ValueText(row, settings, unit);
  if (row.is_file) return absl::StrCat(text.size(), " bytes of PNG");
  return absl::StrCat(row.prefix, absl::CHexEscape(text));
}

absl::Status CheckRobotSettings(const v1::RobotSettings& settings) {
  RETURN_IF_ERROR(ParseMissionName(settings.mission()).status());
  if (!settings.agent().empty()) RETURN_IF_ERROR(CheckNameSegment("agent", settings.agent()));
  if (settings.version() == 0) return BadSetting("version", "0", "at least 1");
  for (const RobotSetting& row : kTable) {
    if (HasSetting(row, settings)) RETURN_IF_ERROR(Check(row, settings));
  }
  return CheckTogether(settings);
}

}  // namespace corbslam::services
