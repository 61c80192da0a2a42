// ask HOST:PORT: lists the services of a server.
// ask HOST:PORT PACKAGE.SERVICE/METHOD [JSON]: calls one of its methods and prints the answers.
#include <iostream>
#include <string>

#include "services/remote/channel.h"
#include "services/testing/generic_client.h"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: ask HOST:PORT [PACKAGE.SERVICE/METHOD [JSON]]\n";
    return 2;
  }
  corbslam::GenericClient client(corbslam::MakeChannel(argv[1]));
  const auto answers =
      argc == 2 ? client.ListServices() : client.Call(argv[2], argc > 3 ? argv[3] : "{}");
  if (!answers.ok()) {
    std::cerr << answers.status() << "\n";
    return 1;
  }
  for (const std::string& answer : *answers) std::cout << answer << "\n";
  return 0;
}
