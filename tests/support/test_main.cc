// The main function of every test program. ctest starts a process for each test and runs several
// side by side, so each process gets a folder of its own as ::testing::TempDir(): no test meets
// another one's files. The folder stays where a test fails.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  std::string folder = testing::TempDir() + "corbslam_test_XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) {
    std::perror(folder.c_str());
    return 1;
  }
  setenv("TEST_TMPDIR", (folder + "/").c_str(), 1);
  const int failed = RUN_ALL_TESTS();
  if (failed != 0) {
    std::fprintf(stderr, "Files of this run: %s\n", folder.c_str());
    return failed;
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return 0;
}
