#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/time/time.h"
#include "client_agent/live/live_sources.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/live_opening.h"
#include "client_agent/source/rig/convert/rig_convert.h"
#include "client_agent/source/rig/rig_file.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/result.h"
#include "services/tool/rig/retake.h"
#include "services/tool/rig/rig_check.h"
#include "slam/rendering/map_picture.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using client_agent::ConvertedRig;
using client_agent::ConvertRig;
using client_agent::FormatRig;
using client_agent::FrameReader;
using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::PictureSize;
using client_agent::ReadRigFile;
using client_agent::Rig;
using client_agent::RigFiles;
using client_agent::SourceSpec;
using client_agent::UseRig;

namespace {

struct ConvertArguments {
  RigFiles files;
  std::string size;
  std::optional<double> rate_hz;
  std::string mask;
  std::string out;
};

struct RetakeArguments {
  std::string source;
  std::string rig;
  std::string out;
};

struct CheckArguments {
  std::string source;
  std::string rig;
  std::string out;
  double seconds = 10;
};

absl::StatusOr<std::optional<PictureSize>> ParseSize(const std::string& text) {
  if (text.empty()) return std::nullopt;
  PictureSize size;
  const std::vector<std::string> sides = absl::StrSplit(text, 'x');
  if (sides.size() == 2 && absl::SimpleAtoi(sides[0], &size.width_px) &&
      absl::SimpleAtoi(sides[1], &size.height_px)) {
    return size;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("--size is \"", text, "\", must be WIDTHxHEIGHT in pixels, as 640x480"));
}

absl::Status Convert(const ConvertArguments& arguments) {
  RigFiles files = arguments.files;
  ASSIGN_OR_RETURN(files.size, ParseSize(arguments.size));
  ASSIGN_OR_RETURN(ConvertedRig converted, ConvertRig(files));
  if (arguments.rate_hz.has_value()) converted.rig.rate_hz = arguments.rate_hz;
  if (!arguments.mask.empty()) converted.rig.mask_file = arguments.mask;
  RETURN_IF_ERROR(Validate(converted.rig));
  for (const std::string& note : converted.notes) {
    if (!WantsJson()) std::fprintf(stderr, "corbslam: note: %s\n", note.c_str());
  }
  const std::string text = FormatRig(
      converted.rig, absl::StrCat(absl::StrJoin(files.paths, ", "), " (", converted.format, ")"));
  nlohmann::ordered_json json = {{"format", converted.format}, {"notes", converted.notes}};
  if (arguments.out.empty()) {
    json["rig"] = text;
    PrintResult(text, json);
    return absl::OkStatus();
  }
  std::vector<std::string> lines = absl::StrSplit(text, '\n');
  lines.pop_back();  // What follows the last line's end.
  RETURN_IF_ERROR(WriteLines(lines, arguments.out));
  json["file"] = arguments.out;
  PrintResult("", json);
  return absl::OkStatus();
}

absl::StatusOr<RigCheck> CheckSource(const SourceSpec& spec, double seconds) {
  if (!client_agent::IsLive(spec)) {
    ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(spec));
    return CheckRig(*reader, spec);
  }
  const absl::Notification never;  // Ctrl-C ends the program.
  ASSIGN_OR_RETURN(const client_agent::LiveSource camera,
                   client_agent::OpenLiveSource(spec, never));
  if (!WantsJson())
    std::fprintf(stderr, "corbslam: looking at the camera for %g s; move it\n", seconds);
  return CheckLiveRig(*camera.stream, camera.description, absl::Seconds(seconds));
}

nlohmann::ordered_json RigCheckToJson(const RigCheck& check) {
  nlohmann::ordered_json description = nlohmann::ordered_json::object();
  for (const auto& [name, value] : check.description) description[name] = value;
  nlohmann::ordered_json findings = nlohmann::ordered_json::array();
  for (const client_agent::SourceFinding& finding : check.findings) {
    const bool is_error = finding.level == client_agent::FindingLevel::kError;
    findings.push_back({{"level", is_error ? "error" : "warning"},
                        {"code", finding.code},
                        {"text", finding.text}});
  }
  return {{"usable", check.IsUsable()}, {"description", description}, {"findings", findings}};
}

absl::Status Check(const CheckArguments& arguments) {
  client_agent::RegisterLiveSources();
  ASSIGN_OR_RETURN(SourceSpec spec, ParseSourceSpec(arguments.source));
  if (!arguments.rig.empty()) RETURN_IF_ERROR(UseRig(arguments.rig, spec));
  ASSIGN_OR_RETURN(const RigCheck check, CheckSource(spec, arguments.seconds));
  std::string text = FormatRigCheck(check);
  nlohmann::ordered_json json = RigCheckToJson(check);
  if (!arguments.out.empty() && !check.picture.empty()) {
    RETURN_IF_ERROR(WriteImage(check.picture, arguments.out));
    absl::StrAppend(&text, "picture: ", arguments.out, "\n");
    json["picture"] = arguments.out;
  }
  PrintResult(text, json);
  if (check.IsUsable()) return absl::OkStatus();
  return absl::FailedPreconditionError("the rig is not that of these pictures; see above");
}

absl::Status TakeAgain(const RetakeArguments& arguments) {
  ASSIGN_OR_RETURN(const SourceSpec spec, ParseSourceSpec(arguments.source));
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(spec));
  ASSIGN_OR_RETURN(const Rig rig, ReadRigFile(arguments.rig));
  RETURN_IF_ERROR(CheckNewFolder(arguments.out));
  ASSIGN_OR_RETURN(const size_t frames, Retake(*reader, spec, rig, arguments.out));
  const std::string source =
      absl::StrCat("kitti:", arguments.out, "?rig=", arguments.out, "/rig.yaml");
  const bool has_imu =
      std::visit([](const auto& kind) { return kind.imu.has_value(); }, reader->calibration());
  if (has_imu && !WantsJson()) {
    std::fprintf(stderr, "corbslam: note: what the IMU measured is not written\n");
  }
  PrintResult(absl::StrCat(frames, " frames; play them as ", source, "\n"),
              {{"frames", frames}, {"source", source}, {"without_imu", has_imu}});
  return absl::OkStatus();
}

std::vector<std::string> FormatNames() {
  std::vector<std::string> names;
  for (const absl::string_view name : client_agent::RigFormats()) names.emplace_back(name);
  return names;
}

void AddConvert(CLI::App& rig, Command& chosen) {
  auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* convert = rig.add_subcommand(
      "convert", "Make a rig file of what Kalibr, ROS, OpenCV, ORB-SLAM or another system wrote");
  convert
      ->add_option("files", arguments->files.paths, "The calibration's file or files, left first")
      ->required();
  convert
      ->add_option("--format", arguments->files.format,
                   absl::StrCat("One of ", absl::StrJoin(client_agent::RigFormats(), ", "),
                                "; else found out from the files"))
      ->check(CLI::IsMember(FormatNames()));
  convert->add_option("--size", arguments->size,
                      "WIDTHxHEIGHT of the pictures, where the files leave it out");
  convert->add_option("--lens", arguments->files.lens,
                      "Of OpenCV's D with 4 numbers: radial-tangential, or equidistant "
                      "(cv::fisheye)");
  convert->add_option("--rate", arguments->rate_hz, "Frames a second")
      ->check(CLI::Range(0.001, 10000.0));
  convert->add_option("--mask", arguments->mask, "Picture that is black where the robot is seen");
  convert->add_flag("--trust-calibration", arguments->files.trust,
                    "Also take an improbable calibration");
  convert->add_option("--out", arguments->out, "File to write; else it is printed");
  convert->callback([arguments, &chosen] { chosen = [arguments] { return Convert(*arguments); }; });
}

void AddCheck(CLI::App& rig, Command& chosen) {
  auto arguments = std::make_shared<CheckArguments>();
  CLI::App* check = rig.add_subcommand(
      "check", "Say whether a rig file is that of the cameras that took the pictures");
  check->add_option("--source", arguments->source, "The pictures, as client_agent takes them")
      ->required();
  check->add_option("--rig", arguments->rig, "The rig file; else the recording's own calibration");
  check->add_option("--out", arguments->out, "Picture to write: rectified, with rows and matches");
  check->add_option("--seconds", arguments->seconds, "How long to look at a live camera's frames")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  check->callback([arguments, &chosen] { chosen = [arguments] { return Check(*arguments); }; });
}

void AddRetake(CLI::App& rig, Command& chosen) {
  auto arguments = std::make_shared<RetakeArguments>();
  CLI::App* retake = rig.add_subcommand(
      "retake", "Write a rectified stereo recording as another rig's cameras would have taken it");
  retake->add_option("--source", arguments->source, "The recording, as client_agent takes it")
      ->required();
  retake->add_option("--rig", arguments->rig, "The other cameras, with the same baseline")
      ->required();
  retake->add_option("--out", arguments->out, "Folder to write")->required();
  retake->callback(
      [arguments, &chosen] { chosen = [arguments] { return TakeAgain(*arguments); }; });
}

}  // namespace

void AddRigCommand(CLI::App& app, Command& chosen) {
  CLI::App* rig = app.add_subcommand("rig", "Make and check rig files, which describe cameras");
  rig->require_subcommand(1);
  AddConvert(*rig, chosen);
  AddCheck(*rig, chosen);
  AddRetake(*rig, chosen);
}

}  // namespace corbslam::services
