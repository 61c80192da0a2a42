// Feeds a program's --config file: flags of every type, the limits among them.
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "services/command_line/command_line.h"
#include "services/programs/limit_flags.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/messages.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;            // NOLINT
  using namespace corbslam::services;  // NOLINT
  using map_store::MapStoreOptions;
  using namespace corbslam::tests;  // NOLINT
  const std::string path = WriteFuzzFile("config.toml", AsText(data, size));
  CLI::App app("program");
  MapStoreOptions store;
  StreamLimitOptions streams;
  AddStoreLimitFlags(app, store);
  AddStreamLimitFlags(app, streams);
  std::string address;
  std::vector<std::string> workers;
  bool insecure = false;
  app.add_option("--listen", address);
  app.add_option("--worker", workers);
  app.add_flag("--insecure", insecure);
  CommandLine command_line(&app, "program");
  const std::string config = "--config=" + path;
  const char* const arguments[] = {"program", config.c_str()};
  try {
    command_line.Parse(2, arguments);
    (void)command_line.DescribeConfiguration();
    (void)store.Validate();
  } catch (const CLI::Error&) {
    // ParseOrExit catches this, too; any other exception would end the program without a word.
  }
  return 0;
}
