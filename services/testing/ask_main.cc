// ask HOST:PORT lists the services of a server.
// ask HOST:PORT PACKAGE.SERVICE/METHOD [JSON] calls one of its methods and prints the answers.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/runtime/address.h"
#include "services/security/flags.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

struct Flags {
  std::string address;
  std::string method;
  std::string request = "{}";
  bool omit_defaults = false;
  double max_time_s = 0;
  SecurityOptions security;
};

absl::Status Ask(const Flags& flags) {
  RETURN_IF_ERROR(ParseServerAddress(flags.address).status());
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(flags.security));
  GenericClient client(MakeChannel(flags.address, credentials));
  GenericCallOptions options;
  options.defaults = !flags.omit_defaults;
  options.may_be_cut = flags.max_time_s > 0;
  if (options.may_be_cut) options.max_time = absl::Seconds(flags.max_time_s);
  ASSIGN_OR_RETURN(const std::vector<std::string> answers,
                   flags.method.empty() ? client.ListServices()
                                        : client.Call(flags.method, flags.request, options));
  for (const std::string& answer : answers) std::cout << answer << "\n";
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::services

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_ERROR;
  corbslam::services::Flags flags;
  CLI::App app("Asks a server that has reflection on", "ask");
  app.add_option("address", flags.address, "HOST:PORT")->required();
  app.add_option("method", flags.method, "PACKAGE.SERVICE/METHOD; without: lists the services");
  app.add_option("request", flags.request, "JSON")->capture_default_str();
  app.add_flag("--omit-defaults", flags.omit_defaults, "Leave out fields with default values");
  app.add_option("--max-time", flags.max_time_s, "Seconds after which a stream's answer is whole");
  corbslam::services::AddTlsFlags(app, flags.security);
  corbslam::services::AddClientFlags(app, flags.security);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::services::Ask(flags);
  if (status.ok()) return 0;
  std::cerr << status << "\n";
  return 1;
}
