// map_viewer shows the maps of a map store in browsers, live.
#include <glog/logging.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "services/client/remote/channel.h"
#include "services/command_line/setting.h"
#include "services/convert/resource_names.h"
#include "services/http/browser_options.h"
#include "services/http/web_host.h"
#include "services/http/web_server.h"
#include "services/programs/checks.h"
#include "services/programs/observe_flags.h"
#include "services/programs/program.h"
#include "services/programs/start_lines.h"
#include "services/programs/viewer_observers.h"
#include "services/security/flags.h"
#include "services/server/self_watch.h"
#include "services/server/served_ports.h"
#include "services/server/server.h"
#include "services/viewer/page_files.h"
#include "services/viewer/page_path.h"
#include "services/viewer/truths.h"
#include "services/viewer/viewer.h"
#include "services/viewer/web_certificate.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

struct Flags {
  std::string listen = "127.0.0.1:8080";
  std::string store = "127.0.0.1:50051";
  std::vector<std::string> robots;
  std::vector<std::string> truths;
  std::string page = DefaultPagePath();
  // Of the way to the store.
  SecurityOptions security;
  // Of the way from browsers.
  std::string web_certificate;
  std::string web_key;
  std::vector<std::string> web_hosts;
  std::string token_key;
  SecurityOptions tokens;  // What --help-all shows about browsers' tokens.
  bool open = false;
  size_t max_pages = BrowserOptions().max_streams;
  ViewerOptions viewer;
  ObserveFlags observe;
};

// Reads "MISSION/AGENT=HOST:PORT".
struct RobotFlag {
  std::string mission;
  std::string agent;
  std::string address;
};
absl::StatusOr<RobotFlag> ParseRobot(const std::string& text) {
  const std::pair<std::string, std::string> parts = absl::StrSplit(text, absl::MaxSplits('=', 1));
  const std::vector<std::string> names = absl::StrSplit(parts.first, '/');
  if (names.size() != 2 || parts.second.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--robot is \"", text, "\", must be MISSION/AGENT=HOST:PORT"));
  }
  RETURN_IF_ERROR(CheckNameSegment("--robot's mission", names[0]));
  RETURN_IF_ERROR(CheckNameSegment("--robot's agent", names[1]));
  RETURN_IF_ERROR(CheckFlagServer("--robot", parts.second));
  return RobotFlag{names[0], names[1], parts.second};
}

absl::StatusOr<MissionFeeds::Robots> MakeRobots(
    const Flags& flags, const std::shared_ptr<grpc::ChannelCredentials>& credentials) {
  MissionFeeds::Robots robots;
  for (const std::string& text : flags.robots) {
    ASSIGN_OR_RETURN(const RobotFlag robot, ParseRobot(text));
    robots[robot.mission].push_back({robot.agent, MakeChannel(robot.address, credentials)});
  }
  return robots;
}

// Returns null if everybody may look.
absl::StatusOr<std::shared_ptr<const AccessControl>> MakeAccess(const Flags& flags) {
  if (flags.token_key.empty()) {
    const SecurityOptions& tokens = flags.tokens;
    if (!tokens.revoked_file.empty() || !tokens.audience.empty() ||
        tokens.max_token_lifetime < absl::InfiniteDuration()) {
      return absl::InvalidArgumentError(
          "--revoked-tokens, --token-audience and --max-token-lifetime need --token-key");
    }
    if (flags.open || flags.security.insecure) return nullptr;
    return absl::InvalidArgumentError(
        "a viewer needs to know who may look: --token-key, whose tokens browsers then show, or "
        "--open for everybody who reaches it (docs/viewer.md)");
  }
  if (flags.open) return absl::InvalidArgumentError("--open and --token-key exclude each other");
  SecurityOptions tokens = flags.tokens;
  tokens.token_key_file = flags.token_key;
  return MakeTokenAccess(tokens);
}

// Returns a channel over which the store can be asked about browsers' tokens; null: none are shown,
// or the way to the store is no place for them.
absl::StatusOr<std::shared_ptr<grpc::Channel>> MakeTokenChannel(const Flags& flags,
                                                                bool takes_tokens) {
  if (!takes_tokens || flags.security.insecure) return nullptr;
  SecurityOptions without_token = flags.security;
  without_token.token_file.clear();
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(without_token));
  return MakeChannel(flags.store, credentials);
}

// Returns null if browsers come without TLS.
absl::StatusOr<std::shared_ptr<const WebTls>> MakeWebTls(const Flags& flags) {
  if (flags.web_certificate.empty() && flags.web_key.empty()) return nullptr;
  if (flags.web_certificate.empty() || flags.web_key.empty()) {
    return absl::InvalidArgumentError("--web-cert and --web-key go together");
  }
  return WatchWebCertificate(flags.web_certificate, flags.web_key);
}

// Returns the names by which browsers may call the viewer; nullopt: any, since TLS sees to it.
absl::StatusOr<std::optional<std::vector<std::string>>> MakeWebHosts(const Flags& flags) {
  for (const std::string& name : flags.web_hosts) {
    RETURN_IF_ERROR(CheckHostName("--web-host", name));
  }
  if (!flags.web_certificate.empty() && flags.web_hosts.empty()) return std::nullopt;
  return flags.web_hosts;
}

bool IsLoopback(const std::string& address) {
  return absl::StartsWith(address, "127.") || absl::StartsWith(address, "[::1]");
}

void WarnOfOpenDoors(const Flags& flags, bool everybody, bool tls) {
  if (IsLoopback(flags.listen)) return;
  LOG_IF(WARNING, everybody) << "everybody who reaches " << flags.listen
                             << " may look at every mission";
  LOG_IF(WARNING, !everybody && !tls)
      << "tokens come to " << flags.listen << " without TLS: anybody on the way can read them, "
      << "unless a proxy in front has --web-cert's part";
}

std::vector<absl::Status> Check(const Flags& flags) {
  std::vector<absl::Status> found = CheckObserving(flags.observe);
  found.push_back(CheckHttpAddress(flags.listen));
  found.push_back(CheckFlagServer("--store", flags.store));
  found.push_back(MakeChannelCredentials(flags.security).status());
  for (const std::string& robot : flags.robots) found.push_back(ParseRobot(robot).status());
  found.push_back(ReadTruths(flags.truths).status());
  found.push_back(MakeAccess(flags).status());
  found.push_back(MakeWebTls(flags).status());
  found.push_back(MakeWebHosts(flags).status());
  found.push_back(PageFiles::Load(flags.page).status());
  return found;
}

absl::Status Run(Flags flags) {
  RETURN_IF_ERROR(CheckFlagServer("--store", flags.store));
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(flags.security));
  ASSIGN_OR_RETURN(const auto access, MakeAccess(flags));
  ASSIGN_OR_RETURN(const auto tls, MakeWebTls(flags));
  WebServerOptions web = BrowserOptions(tls);
  web.max_streams = flags.max_pages;
  ASSIGN_OR_RETURN(web.hosts, MakeWebHosts(flags));
  ASSIGN_OR_RETURN(MissionFeeds::Robots robots, MakeRobots(flags, credentials));
  ASSIGN_OR_RETURN(flags.viewer.truths, ReadTruths(flags.truths));
  absl::StatusOr<PageFiles> page = PageFiles::Load(flags.page);
  if (!page.ok()) LOG(ERROR) << page.status().message();
  WarnOfOpenDoors(flags, access == nullptr, tls != nullptr);
  // Each page has more connections for what it asks.
  web.connections.all = std::max(web.connections.all, 4 * web.max_streams);
  web.connections.of_host = std::max(web.connections.of_host, 2 * web.max_streams);
  const auto channel = MakeChannel(flags.store, credentials);
  ASSIGN_OR_RETURN(flags.viewer.token_channel, MakeTokenChannel(flags, access != nullptr));
  flags.viewer.connect = ConnectWith(credentials);
  Viewer viewer(channel, std::move(robots), access, std::move(page), flags.viewer);
  ASSIGN_OR_RETURN(const std::unique_ptr<WebServer> server,
                   WebServer::Start(flags.listen, &viewer, web));
  const ServedPort port("web", [&server] { return server->connections(); });
  ASSIGN_OR_RETURN(const auto metrics, ServeViewerMetrics(flags.observe, viewer, *server));
  LOG(INFO) << "shows browsers at " << (tls != nullptr ? "https://" : "http://")
            << server->address() << " the maps of " << flags.store << " ("
            << DescribeCalling(flags.security) << "), "
            << (access == nullptr ? "to everybody" : "to who has a token");
  AnnounceAddress(server->address());
  SelfWatch watch({.address = server->address()});
  WaitForStopSignal();
  watch.Stop();
  return absl::OkStatus();
}

void AddFlags(CLI::App& app, Flags& flags) {
  AddSettings(
      app,
      {
          {"--listen", &flags.listen, "IP:PORT to serve browsers on; port 0: any free one"},
          {"--store", &flags.store, "HOST:PORT of the map store"},
          {"--robot", &flags.robots,
           "MISSION/AGENT=HOST:PORT of a robot to ask how it is; may be repeated"},
          {"--truth", &flags.truths,
           "MISSION=FILE of where its cameras really were, in TUM's format, drawn dashed; may be "
           "repeated"},
          {"--page", &flags.page, "Folder of the built page"},
          {"--web-cert", &flags.web_certificate,
           "PEM file of the certificate that browsers are shown; without: no TLS"},
          {"--web-key", &flags.web_key, "PEM file of its private key"},
          {"--web-host", &flags.web_hosts,
           "Name by which browsers may call it, beside its IP addresses and localhost; * for any; "
           "may be repeated; without, with TLS: any"},
          {"--token-key", &flags.token_key,
           "PEM file of Ed25519 public keys whose tokens browsers show"},
          {"--open", &flags.open, "Everybody who reaches it may look at every mission"},
          {"--max-pages", &flags.max_pages, "Pages that are open at once", Within(1, 10000)},
          {"--max-missions", &flags.viewer.feeds.max_missions,
           "Missions that are looked at at once", Within(1, 1000)},
      });
  AddTokenFlags(app, flags.tokens);
  AddTlsFlags(app, flags.security);
  AddClientFlags(app, flags.security);
  AddMetricsFlag(app, flags.observe);
}

}  // namespace
}  // namespace corbslam::services

int main(int argc, char** argv) {
  corbslam::services::BlockStopSignals();
  corbslam::services::Flags flags;
  CLI::App app("Shows the maps of a map store in browsers, live", "map_viewer");
  corbslam::services::AddFlags(app, flags);
  return corbslam::services::RunProgram(app, argc, argv,
                                        {[&] { return corbslam::services::Run(flags); },
                                         [&] { return corbslam::services::Check(flags); }});
}
