#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/rig/rig_file.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/security/flags.h"
#include "services/tool/commands/commands.h"
#include "services/tool/mission/picture_search.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

struct LocalizeArguments {
  std::string server;
  SecurityOptions security;
  PictureSearch search;
  std::string rig;
  std::string camera;
  std::string near;
  bool json = false;
};

absl::Status SetCamera(const LocalizeArguments& arguments, PictureSearch& search) {
  if (arguments.rig.empty()) {
    ASSIGN_OR_RETURN(search.camera, ParseCamera(arguments.camera));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const client_agent::Rig rig, client_agent::ReadRigFile(arguments.rig));
  search.camera = rig.cameras[0].raw;
  search.width_px = rig.cameras[0].width_px;
  search.height_px = rig.cameras[0].height_px;
  search.calibration = arguments.rig;
  return absl::OkStatus();
}

// Throws what wrong flags end with.
void CheckFlags(const LocalizeArguments& arguments) {
  const auto refuse = [](const std::string& why) {
    throw CLI::ParseError(why, CLI::ExitCodes::ValidationError);
  };
  if (arguments.rig.empty() && arguments.camera.empty()) {
    refuse(
        "localize needs the camera that took the pictures: --rig FILE (docs/rig.md), or for one "
        "whose lens doesn't distort --camera \"FX FY CX CY\", in pixels of these pictures");
  }
  if (!arguments.rig.empty() && !arguments.camera.empty()) {
    refuse("--rig and --camera both say which camera took the pictures: give one of them");
  }
  const absl::StatusOr<RawCamera> camera =
      arguments.camera.empty() ? RawCamera() : ParseCamera(arguments.camera);
  if (!camera.ok()) refuse(std::string(camera.status().message()));
}

absl::Status Localize(LocalizeArguments arguments) {
  PictureSearch& search = arguments.search;
  RETURN_IF_ERROR(CheckNameSegment("--mission", search.mission));
  RETURN_IF_ERROR(SetCamera(arguments, search));
  if (!arguments.near.empty()) {
    ASSIGN_OR_RETURN(search.near_m, ParsePlace(arguments.near));
  }
  ASSIGN_OR_RETURN(const auto channel,
                   ConnectToStoreOf(search.mission, arguments.server, arguments.security));
  ASSIGN_OR_RETURN(const std::vector<FoundPicture> found, FindPictures(channel, search));
  nlohmann::json rows = nlohmann::json::array();
  for (const FoundPicture& picture : found) {
    if (arguments.json) {
      rows.push_back(ToJson(picture));
    } else {
      std::fputs(DescribeFound(picture).c_str(), stdout);
    }
  }
  if (arguments.json) std::printf("%s\n", rows.dump(2).c_str());
  const auto lost = std::ranges::count_if(found, [](const FoundPicture& picture) {
    return picture.answer.stage() != v1::LOCATE_STAGE_LOCATED;
  });
  if (lost == 0) return absl::OkStatus();
  return absl::NotFoundError(absl::StrCat(lost, " of ", found.size(), " pictures were not found"));
}

}  // namespace

void AddLocalizeCommand(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<LocalizeArguments>();
  CLI::App* action = app.add_subcommand("localize", "Where in a mission's map a picture was taken");
  action->add_option("PICTURE", arguments->search.pictures, "PNG or JPEG files of one camera")
      ->required();
  action->add_option("--server", arguments->server, "HOST:PORT of the map store")->required();
  action->add_option("--mission", arguments->search.mission, "Its name")->required();
  action->add_option("--rig", arguments->rig,
                     "Rig file (docs/rig.md) whose first camera took them");
  action->add_option("--camera", arguments->camera,
                     "\"FX FY CX CY\" in pixels, of a camera without distortion");
  auto* near = action->add_option("--near", arguments->near,
                                  "\"X Y Z\" in the global frame: only around there, metres");
  auto* radius =
      action->add_option("--radius", arguments->search.radius_m, "Within so many metres of --near")
          ->check(CLI::Range(0.001, 1e6));
  near->needs(radius);
  radius->needs(near);
  action->add_flag("--all-islands", arguments->search.all_islands,
                   "Also in maps that are not in the global frame");
  action->add_flag("--json", arguments->json, "Print JSON, for scripts");
  AddTlsFlags(*action, arguments->security);
  AddClientFlags(*action, arguments->security);
  action->callback([arguments, &chosen] {
    CheckFlags(*arguments);
    chosen = [=] { return Localize(*arguments); };
  });
}

}  // namespace corbslam::services
